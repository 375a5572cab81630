# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One page at its socket: its messages read within bounds, snapshots sent by credit; its requests
carried out in the session and answered; who owns which handle.
"""

import asyncio
import contextlib
import json
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from websockets.asyncio.server import ServerConnection, broadcast
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode

from pmwvc_view.protocol import CREDITS, MESSAGES_HZ, SILENCE_S, ProtocolError, Request, read
from pmwvc_view.protocol.snapshot import Layout, Snapshot
from pmwvc_view.session import Handled, Session

LONGEST_REASON = 100  # bytes; a close frame holds 123
MOST_PACKETS = 512  # of a snapshot; the oldest are left out
MOST_WAITING = 64  # messages beside snapshots; a page that takes no more is closed


class Client:
    """A connected page. One that is slow is sent the present, with the extremes and packets of all
    that it missed; others share the message of a snapshot.
    """

    def __init__(self, socket: ServerConnection, layout: Layout) -> None:
        self._socket, self._work, self._full = socket, asyncio.Event(), False
        self._messages: deque[str] = deque()
        self.begin(layout)

    def begin(self, layout: Layout) -> None:
        """Begin with a layout, at first and whenever the session is begun again."""
        self._low, self._high = layout.positions("f_min"), layout.positions("f_max", "lateness")
        self._waiting: Snapshot | None = None  # all that was not sent yet, as one
        self._unseen: deque[int] = deque()

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
            if (before := self._waiting) is not None:
                row = snapshot.row.copy()
                row[self._low] = np.fmin(row[self._low], before.row[self._low])
                row[self._high] = np.fmax(row[self._high], before.row[self._high])
                packets = np.concatenate([before.packets, snapshot.packets])[-MOST_PACKETS:]
                snapshot = Snapshot(row, packets)
            self._waiting = snapshot
        self._send_snapshot()

    def seen(self, seq: int) -> None:
        """Note that the page has taken in every snapshot up to this number."""
        while self._unseen and self._unseen[0] <= seq:
            self._unseen.popleft()
        self._send_snapshot()

    def _send_snapshot(self) -> None:
        """Send the snapshot that waits, behind messages; credits bound what the socket holds."""
        if (snapshot := self._waiting) and not self._messages and len(self._unseen) < CREDITS:
            self._waiting = None
            self._unseen.append(int(snapshot.row[0]))
            broadcast((self._socket,), snapshot.message)

    async def run(self, handle: Callable[[Request], None]) -> str:
        """Read and write until the page is gone; return what rule it broke, or ""."""
        tasks = [asyncio.create_task(self._read(handle)), asyncio.create_task(self._write())]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        with contextlib.suppress(ConnectionClosed):
            return "".join(task.result() for task in done)
        return ""

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
        begun_s, count = clock(), 0  # a second, and its messages
        async for message in self._socket:
            if clock() - begun_s > 1.0:
                begun_s, count = clock(), 0
            if (count := count + 1) > MESSAGES_HZ:
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


MOST_AT_ONCE = 8  # changes of one page that are under way
AGAIN_S = 1.0  # between two beginnings


class Handling:
    """The requests of pages, answered; ``tell_users`` tells every page who owns which handle."""

    def __init__(self, session: Session, tell_users: Callable[[], None]) -> None:
        self._session, self._tell_users = session, tell_users
        self._owners: dict[str, Client | None] = {}  # of every handle that can be taken
        self._tasks: dict[asyncio.Task[None], Client] = {}
        self._listened_s = self._began_s = 0.0
        self.begin()

    def begin(self) -> None:
        """Begin anew with the session; handles stay whose they are."""
        self._owners = {user: self._owners.get(user) for user in self._session.remote}
        self._held_s: dict[str, float] = {}  # of those whose hand is closed: newest target

    def holders(self, client: Client) -> dict[str, str | None]:
        """Return who holds each user's handle, as a page is told."""
        words, users = {None: None, client: "you"}, self._session.layout.users
        return {user: words.get(self._owners.get(user), "other") for user in users}

    def listened(self, time_s: float) -> None:
        """Note for how long pages were listened to [s]; open hands that got no target for long."""
        self._listened_s += time_s
        for user, at_s in list(self._held_s.items()):
            if self._listened_s - at_s > SILENCE_S:
                self._open(user)

    def gone(self, client: Client) -> None:
        """Free the handles of a page that is gone."""
        for user in [user for user, owner in self._owners.items() if owner is client]:
            self._free(user)

    def _free(self, user: str) -> None:
        self._open(user)
        self._owners[user] = None
        self._tell_users()

    def _open(self, user: str) -> None:
        self._held_s.pop(user, None)
        self._session.target(user, None)

    def handle(self, client: Client, request: Request) -> None:
        """Do what a page asks for; answers that take their time come later."""
        if request.kind == "seen":
            client.seen(request.values["seq"])
        elif request.kind == "target":
            self._target(client, **request.values)
        elif (answer := self._done(client, request)) is not None:
            self._answer(client, request, answer)

    def _done(self, client: Client, request: Request) -> Handled | None:
        """Do what a page asks for, and return the answer; None where that takes its time."""
        kind, values = request.kind, request.values
        if kind not in self._session.can:
            return Handled(False, f"{kind}: not in this session")
        if kind == "take":
            return self._take(client, values["user"])
        if kind == "let_go":
            mine = self._owners.get(values["user"]) is client
            if mine:
                self._free(values["user"])
            return Handled(mine, "" if mine else "not held by this page")
        if kind in ("set", "ask", "pause"):
            under_way = list(self._tasks.values()).count(client)
            if kind != "ask" and under_way >= MOST_AT_ONCE:  # of questions the newest counts
                return Handled(False, f"{MOST_AT_ONCE} changes of this page are under way")
            task = asyncio.create_task(self._later(client, request))
            self._tasks[task] = client
            task.add_done_callback(self._tasks.pop)
            return None
        if kind == "restart":
            before_s, now_s = self._began_s, asyncio.get_running_loop().time()
            if now_s - before_s < AGAIN_S:
                return Handled(False, f"it began less than {AGAIN_S:g} s ago")
            self._began_s = now_s
        found: Handled = getattr(self._session, kind)(**values)
        return found

    def _take(self, client: Client, user: str) -> Handled:
        """Give a handle to a page."""
        if user not in self._owners:
            return Handled(False, f"{user}: has no handle that can be taken here")
        if self._owners[user] not in (None, client):
            return Handled(False, f"{user}: another page holds it")
        self._owners[user] = client
        self._tell_users()
        return Handled(True)

    def _target(self, client: Client, user: str, position: Sequence[float] | None) -> None:
        if self._owners.get(user) is not client:
            return
        if position is None:
            self._open(user)
        else:
            self._held_s[user] = self._listened_s
            self._session.target(user, tuple(map(float, position)))

    async def _later(self, client: Client, request: Request) -> None:
        found = await getattr(self._session, request.kind)(**request.values)
        if request.kind != "ask":
            self._answer(client, request, found)
        elif found is None:
            self._answer(client, request, Handled(False, "a newer question came"))
        else:
            client.send({"kind": "prediction", "id": request.id, **found})

    def _answer(self, client: Client, request: Request, answer: Handled) -> None:
        if request.id is not None:
            client.send({"kind": "answer", "id": request.id, **answer._asdict()})
