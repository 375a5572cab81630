# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One page at its socket: its messages read within bounds, snapshots sent by credit."""

import asyncio
import contextlib
import json
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from websockets.asyncio.server import ServerConnection, broadcast
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode

from pmwvc_view.protocol import MESSAGES_HZ
from pmwvc_view.protocol.requests import ProtocolError, Request, read
from pmwvc_view.protocol.snapshot import Layout, Outgoing, Snapshot

LONGEST_REASON = 100  # bytes; a close frame holds 123
MOST_WAITING = 64  # messages beside snapshots; a page that takes no more is closed


class Allowance:
    """Messages that a page may still send, at a mean rate [1/s] and as many at once.

    Times are of any clock [s].
    """

    def __init__(self, rate_hz: float, now_s: float) -> None:
        self._rate_hz = self._left = rate_hz
        self._at_s = now_s

    def spend(self, now_s: float) -> bool:
        """Count one message; return whether it is allowed."""
        self._left = min(self._rate_hz, self._left + (now_s - self._at_s) * self._rate_hz)
        self._at_s = now_s
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class Client:
    """A connected page."""

    def __init__(self, socket: ServerConnection, layout: Layout) -> None:
        self._socket = socket
        self._messages: deque[str] = deque()
        self._outgoing = Outgoing(layout)
        self._work = asyncio.Event()
        self._full = False

    def begin(self, layout: Layout) -> None:
        """Begin with another layout: the session was begun again."""
        self._outgoing = Outgoing(layout)

    def send(self, message: Mapping[str, Any]) -> None:
        """Send a message, in order, as soon as the page takes it."""
        if len(self._messages) < MOST_WAITING:
            self._messages.append(json.dumps(message, allow_nan=False))
        else:
            self._full = True
        self._work.set()

    def show(self, snapshots: Sequence[Snapshot]) -> None:
        """Send the newest snapshots as one, with later ones where the page is not ready yet."""
        for snapshot in snapshots:
            self._outgoing.add(snapshot)
        self._send_snapshot()

    def seen(self, seq: int) -> None:
        """Note that the page has taken in every snapshot up to this number."""
        self._outgoing.seen(seq)
        self._send_snapshot()

    def _send_snapshot(self) -> None:
        """Send the snapshot that waits, behind the messages that do.

        Credits bound what the socket holds, so that there is nothing to wait for.
        """
        if not self._messages:
            snapshot = self._outgoing.take()
            if snapshot is not None:
                broadcast((self._socket,), snapshot)

    async def run(self, handle: Callable[[Request], None]) -> str:
        """Read and write until the page is gone; return what rule it broke, or ""."""
        tasks = [asyncio.create_task(self._read(handle)), asyncio.create_task(self._write())]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        found = ""
        for task in done:
            with contextlib.suppress(ConnectionClosed):
                found = found or task.result()
        return found

    async def _write(self) -> str:
        """Send what waits until the page is gone, or takes nothing any more."""
        while not self._full:
            await self._work.wait()
            self._work.clear()
            while self._messages:
                await self._socket.send(self._messages.popleft())
            self._send_snapshot()
        return "the page takes no messages"

    async def _read(self, handle: Callable[[Request], None]) -> str:
        """Handle the page's requests until it is gone or breaks a rule."""
        clock = asyncio.get_running_loop().time
        allowance = Allowance(MESSAGES_HZ, clock())
        async for message in self._socket:
            if not allowance.spend(clock()):
                return f"more than {MESSAGES_HZ:g} messages a second"
            try:
                if isinstance(message, bytes):
                    raise ProtocolError("a message must be a string")
                request = read(message)
            except ProtocolError as error:
                return str(error)
            handle(request)
        return ""

    async def refuse(self, why: str) -> None:
        """Close the socket of a page that broke a rule."""
        reason = why.encode("ascii", "replace")[:LONGEST_REASON].decode("ascii")
        await self._socket.close(CloseCode.POLICY_VIOLATION, reason)

    async def close(self) -> None:
        """Send what waits, then close: the session is over."""
        with contextlib.suppress(ConnectionClosed):
            while self._messages:
                await self._socket.send(self._messages.popleft())
            await self._socket.close(CloseCode.GOING_AWAY)
