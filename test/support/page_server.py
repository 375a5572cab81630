# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session simulated in real time behind the page's server, in a thread, and all that it showed:
its snapshots, and the force of every tick.
"""

import threading
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.traces import UserTraces
from pmwvc_view.feed.feed import Feed
from pmwvc_view.protocol.snapshot import Snapshot
from pmwvc_view.session import Session
from pmwvc_view.simulated import SimulatedSession
from pmwvc_view.web.server import PageServer
from support import page_sockets
from support.page_sockets import TOKEN
from support.plain import load

__all__ = ["SNAPSHOT_S", "TOKEN", "Served", "served", "serving"]
SNAPSHOT_S = 0.016
PATIENCE = 2500  # snapshots; a machine that stalls takes longer for them


class WatchedSession(SimulatedSession):
    """A simulated session that keeps its snapshots."""

    def __init__(self, scenario: Any) -> None:
        super().__init__(scenario)
        self.shown: list[Snapshot] = []
        self.news_came = threading.Event()

    def poll(self) -> Sequence[Snapshot]:
        """Return the snapshots since the last call, and keep them."""
        found = super().poll()
        self.shown.extend(found)
        self.news_came.set()
        return found


class Served:
    """What a test asks about the session it serves."""

    def __init__(self, session: WatchedSession, server: PageServer, forces: Mapping[str, list]):
        self.session, self.server, self._forces = session, server, forces

    @property
    def address(self) -> str:
        """Address of the page, with its token."""
        return self.server.address

    def series(self, column: str, since: int = 0) -> Array:
        """Return a column of the snapshots from one number on, along the first axis."""
        at = self.session.layout.slices[column].start
        return np.array([snapshot.row[at] for snapshot in self.session.shown[since:]])

    def now(self, column: str) -> float:
        """Return the newest value of a column; NaN before the first snapshot."""
        return float(self.series(column, -1)[-1]) if self.session.shown else float("nan")

    @property
    def count(self) -> int:
        """Number of snapshots so far."""
        return len(self.session.shown)

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Wait until something holds, asking at every snapshot."""
        for _ in range(PATIENCE):
            if condition():
                return
            self.session.news_came.clear()
            assert self.session.news_came.wait(60.0), "the session stands still"
        raise AssertionError(f"did not come to pass: {what}")

    def pass_by(self, snapshots: int) -> None:
        """Wait until some more snapshots were shown."""
        until = self.count + snapshots
        self.until(lambda: self.count >= until, f"{snapshots} snapshots")

    def forces(self, user: str) -> Array:
        """Return the force on a device at every tick so far [N]."""
        return np.concatenate(self._forces[user])[:, 0]


@contextmanager
def serving(session: Session) -> Iterator[PageServer]:
    """Serve a session, until the block ends."""
    with page_sockets.served(session, snapshot_s=SNAPSHOT_S) as found:
        yield found.server


@contextmanager
def served(
    settings: Sequence[str] = (),
    users: int | None = None,
    name: str = "live",
    silent: Container[str] = (),
) -> Iterator[Served]:
    """Serve a scenario with settings, until the block ends; nothing comes from masters of users
    that are ``silent``.
    """
    session = WatchedSession(load(name, settings_texts=settings, users=users))
    forces: dict[str, list[Array]] = {}
    on_master = Feed.on_master

    def kept(feed: Feed, traces: UserTraces) -> None:
        if traces.name in silent:
            return
        forces.setdefault(traces.name, []).append(traces.f_applied)
        on_master(feed, traces)

    Feed.on_master = kept  # type: ignore[method-assign]
    try:
        with serving(session) as server:
            yield Served(session, server, forces)
    finally:
        Feed.on_master = on_master  # type: ignore[method-assign]
