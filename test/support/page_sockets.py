# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A page's server in a thread of its own, a session made by hand behind it, pages as sockets."""

import contextlib
import json
import queue
import threading
from collections.abc import Iterator

import numpy as np
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from pmwvc_bringup import scenarios
from pmwvc_view.protocol.snapshot import Layout, Snapshot
from pmwvc_view.session import Handled, Session
from pmwvc_view.web.server import PageServer

PATIENCE_S = 100.0  # for an event that has to come
TOKEN = "token-of-a-test"


class HandmadeSession(Session):
    """One snapshot a poll; targets go to a queue."""

    can = frozenset({"take", "let_go", "target", "pause", "seen"})

    def __init__(self, users=("user1", "user2")) -> None:
        super().__init__(live=False)
        self.layout = Layout(users, 1)
        self.remote, self.wanted = users, scenarios.load("carry_16ms")
        self.polls = 0
        self.peaks: dict[int, float] = {}  # poll -> f_max of user1
        self.targets: queue.Queue = queue.Queue()
        self._news = threading.Condition()
        self.busy: threading.Semaphore | None = None  # each poll is told with targets, and waits

    def message(self, holders):
        return {"kind": "session", "users": list(holders), "layout": self.layout.to_page()}

    def poll(self):
        if self.busy is not None:
            self.targets.put(None)
            assert self.busy.acquire(timeout=PATIENCE_S)
        with self._news:
            self.polls += 1
            self._news.notify_all()
        row = np.full(self.layout.size, np.nan)
        peak = self.peaks.get(self.polls, 0.0)
        self.layout.set(row, {"seq": self.polls, "time_s": 0.016 * self.polls})
        self.layout.set(row, {"user1.f_min": -peak, "user1.f_max": peak, "user1.lateness": 0.0})
        return [Snapshot(row, np.full((1, 5), float(self.polls)))]

    def news(self):
        return {}

    def target(self, user, position):
        self.targets.put((user, position))

    async def pause(self, paused):
        return Handled(True, "paused")

    _give = _notes = _change = None

    def close(self):
        pass

    def await_polls(self, count: int) -> None:
        """Wait until so many more polls were made."""
        with self._news:
            wanted = self.polls + count
            assert self._news.wait_for(lambda: self.polls >= wanted, PATIENCE_S)


class Page:
    """A page as a socket; snapshots and messages are received in their order."""

    def __init__(self, socket, host: str) -> None:
        self.socket, self.host = socket, host
        self.session = self.receive()
        assert self.session["kind"] == "session"
        self._id = 0

    def receive(self):
        """Return the next message: a dictionary, or a snapshot as numbers."""
        message = self.socket.recv(PATIENCE_S)
        if isinstance(message, bytes):
            return np.frombuffer(message, "<f8")
        return json.loads(message)

    def send(self, kind: str, **fields) -> None:
        """Send a request."""
        self.socket.send(json.dumps({"kind": kind, **fields}))

    def await_kind(self, kind: str):
        """Return the next message of a kind; snapshots before it are acknowledged."""
        while True:
            found = self.receive()
            if isinstance(found, dict):
                if found["kind"] == kind:
                    return found
            else:
                with contextlib.suppress(ConnectionClosed):  # the server's last words can be read
                    self.send("seen", seq=int(found[0]))

    def ask(self, kind: str, **fields):
        """Send a request and return its answer."""
        self._id += 1
        self.send(kind, id=self._id, **fields)
        while (answer := self.await_kind("answer"))["id"] != self._id:
            pass
        return answer


class Served:
    """A running server of a session."""

    def __init__(
        self, session: Session, host: str = "127.0.0.1", snapshot_s: float = 0.002
    ) -> None:
        self.session = session
        self._stop, self._ready = threading.Event(), threading.Event()
        self.server = PageServer(session, host=host, port=0, token=TOKEN, poll_s=snapshot_s)
        self._thread = threading.Thread(target=self.server.run, args=(self._stop, self._ready.set))
        self._thread.start()
        assert self._ready.wait(PATIENCE_S)
        self.host = f"127.0.0.1:{self.server.port}"
        self.port = self.server.port

    @contextlib.contextmanager
    def page(self, *, token: str = TOKEN, origin: str | None = None) -> Iterator[Page]:
        """Connect as a page does."""
        url = f"ws://{self.host}/socket?token={token}"
        with connect(
            url, origin=origin or f"http://{self.host}", compression=None, proxy=None
        ) as socket:
            yield Page(socket, self.host)

    def end(self) -> None:
        """Ask the server to end, and wait until it has."""
        self._stop.set()
        self._thread.join(PATIENCE_S)
        assert not self._thread.is_alive()


@contextlib.contextmanager
def served(session: Session, **options) -> Iterator[Served]:
    """Serve a session until the block ends."""
    server = Served(session, **options)
    try:
        yield server
    finally:
        server.end()
