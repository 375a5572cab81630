# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Pages of a live session as sockets: a pointer that drags, and those who only watch."""

import json
import math
import time
from urllib.parse import parse_qs, urlsplit

import numpy as np
from websockets.sync.client import connect

from support.page_sockets import Page


def address_of(lines) -> str:
    """Read on to the address of a session's page."""
    for line in lines:
        if line.startswith("page: "):
            return line.removeprefix("page: ").strip()
    raise AssertionError("ended without an address")


def opened(address: str):
    """Connect to the socket of a page's address."""
    parts = urlsplit(address)
    token = parse_qs(parts.query)["token"][0]
    url = f"ws://{parts.netloc}/socket?token={token}"
    return connect(url, origin=f"http://{parts.netloc}", compression=None, proxy=None)


class Pointer:
    """A page that takes snapshots and, with a user, moves that hand to and fro.

    Attributes
    ----------
    sent_ns
        When each target was sent, by the wall clock [ns].
    """

    def __init__(self, address: str, *, user: str | None) -> None:
        self._address, self._user = address, user
        self.sent_ns: dict[float, int] = {}

    def run(self, stop) -> None:
        """Take part until asked to stop."""
        with opened(self._address) as socket:
            page = Page(socket, "")
            start = next(u["start_m"][0] for u in page.session["users"] if u["name"] == "user1")
            if self._user:
                page.ask("take", user=self._user)
            begin_s, taken = time.monotonic(), 0
            while not stop.is_set():
                found = page.receive()
                if isinstance(found, np.ndarray):
                    taken += 1
                    if taken % 2 == 0:  # as page/socket.js
                        page.send("seen", seq=int(found[0]))
                    if self._user:
                        place = start - 0.02 * math.sin(6.0 * (time.monotonic() - begin_s))
                        message = {"kind": "target", "user": self._user, "position": [place]}
                        text = json.dumps(message)
                        self.sent_ns[place] = time.time_ns()
                        socket.send(text)
