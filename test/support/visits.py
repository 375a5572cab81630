# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A real session with a page, and people who take hold through it, change the nodes, and go."""

import os
import signal
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.recording.reader import read_scenario, read_session
from support.live_pages import address_of, opened
from support.page_sockets import Page
from support.sessions import Running


class Person:
    """A page whose hand follows a target, as a pointer would: one target a snapshot."""

    def __init__(self, page: Page, user: str) -> None:
        self.page, self.user = page, user
        self.columns, at = {}, 0
        for name, count, _ in page.session["layout"]["columns"]:
            self.columns[name] = slice(at, at + count)
            at += count
        self.target: float | None = None
        self.row = np.full(at, np.nan)
        assert page.ask("take", user=user)["done"]

    def value(self, name: str) -> float:
        """Return a number of the newest snapshot."""
        return float(self.row[self.columns[name]][0])

    def look(self) -> None:
        """Take in the next message; send a target for a snapshot."""
        found = self.page.receive()
        if isinstance(found, np.ndarray):
            self.row = found
            self.page.send("seen", seq=int(found[0]))
            if self.target is not None:
                self.page.send("target", user=self.user, position=[self.target])


def until(condition, *people):
    """Let people look in turns until a condition holds."""
    while not condition():
        for person in people:
            person.look()


def visited(folder: Path) -> dict[str, Any]:
    """Run a session in which two people squeeze the cube, and one of them leaves; return what the
    page answered, and the recording.
    """
    found: dict[str, Any] = {"folder": folder}
    port = str(20_000 + os.getpid() % 10_000)  # below those that the system gives to anybody
    words = ("live", "--view", "--no-browser", "--port", port, "--duration", "300")
    words += ("--set", "master.tick_s=0.002")  # a slow machine has time left for the page
    with Running(folder, *words, figures=True) as session:
        address = address_of(session.process.stdout)
        assert f":{port}/" in address
        with opened(address) as second_socket:
            second = Person(Page(second_socket, ""), "user2")
            with opened(address) as first_socket:
                first = Person(Page(first_socket, ""), "user1")
                both = (first, second)
                until(lambda: first.value("user1.state") == first.value("user2.state") == 1, *both)
                found["before"] = abs(first.value("user1.f_applied"))
                found["second tab"] = second.page.ask("take", user="user1")
                first.target, second.target = -0.016, 0.016
                until(lambda: abs(first.value("user1.f_applied")) > 1.0, *both)
                found["squeezed"] = abs(first.value("user1.f_applied"))
                squeezed_s = first.value("time_s")
                until(lambda: first.value("time_s") > squeezed_s + 0.3, *both)
                second.target = None  # its hand lets go by silence; asking takes its time
                found["delay"] = first.page.ask("set", path="link.delay_s", value=0.02)
                found["beyond"] = first.page.ask("set", path="link.loss", value=2.0)
                found["elsewhere"] = first.page.ask("set", path="device.plugin", value="x")
                for name, value in (
                    ("server.contact_stiffness", 800.0),
                    ("master.impedance", 30.0),
                ):
                    found[name] = first.page.ask("set", path=name, value=value)
                second.target = 0.016
                until(lambda: abs(first.value("user1.f_applied")) > 1.0, *both)
            until(lambda: second.value("user1.held") == 0.0, second)
            left_s = second.value("time_s")
            until(lambda: second.value("time_s") > left_s + 1.0, second)
            # Its place is free once the server has seen that its socket is gone.
            until(lambda: second.page.ask("take", user="user1")["done"], second)
        session.process.send_signal(signal.SIGINT)
        session.end()
    found["traces"], found["scenario"] = read_session(folder), read_scenario(folder)
    return found
