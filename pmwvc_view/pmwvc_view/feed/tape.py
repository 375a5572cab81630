# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The newest seconds of a running session: the traces of its nodes as they come, joined, and the
packets of its links. Times count from the first trace [s].
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, compress
from typing import Any, Generic, TypeVar

import numpy as np

from pmwvc_analysis.traces.stages import with_rows
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import PacketTraces, ServerTraces, SessionTraces, UserTraces

NS = 1_000_000_000
SPAN_S = 6.0  # that is judged
SHOWN_S = 1.0  # of which rows are made: longer than any block, and than a trace that comes late
ROUNDED_S = 1e-6

Traces = TypeVar("Traces", UserTraces, ServerTraces)


def ends_s(traces: UserTraces | ServerTraces) -> Array:
    """Return the ends of a master's blocks, or the steps of the server [s]."""
    return traces.block_time_s if isinstance(traces, UserTraces) else traces.time_s


def joined(parts: Sequence[Traces]) -> Traces:
    """Return consecutive traces of one node as one; what has no rows is the newest's."""
    found: dict[str, Any] = {}
    for name, value in vars(parts[-1]).items():
        every = [getattr(part, name) for part in parts]
        if name == "contacts":  # each names its row
            firsts = np.cumsum([0, *(len(ends_s(part)) for part in parts[:-1])])
            found[name] = np.concatenate(every)
            found[name][:, 0] += np.repeat(firsts, [len(each) for each in every])
        elif isinstance(value, np.ndarray):  # without rows its columns may be unknown
            found[name] = np.concatenate([each for each in every if len(each)] or every[:1])
        elif isinstance(value, dict):  # an account may have come later
            zeros = [np.zeros(len(ends_s(part))) for part in parts]
            found[name] = {
                key: np.concatenate([e.get(key, z) for e, z in zip(every, zeros, strict=True)])
                for key in dict.fromkeys(chain.from_iterable(every))
            }
        elif name == "reason":
            found[name] = list(chain.from_iterable(every))
        elif isinstance(value, list) and name != "users":
            found[name] = [np.concatenate(each) for each in zip(*every, strict=True)]
    return replace(parts[-1], **found)


def since(traces: Traces, start_s: float) -> Traces:
    """Return the steps after a time [s]; of a master the blocks that end after it."""
    kept = ends_s(traces) > start_s
    if kept.all():
        return traces
    if isinstance(traces, ServerTraces):
        return with_rows(traces, kept)
    before_s = float(traces.block_time_s[~kept].max(initial=-math.inf))
    found = with_rows(traces, traces.time_s > before_s - 0.5 * traces.tick_s, kept)
    return replace(found, reason=list(compress(traces.reason, kept)))


class Newest(Generic[Traces]):
    """The newest traces of one node: ``shown`` is the newest second, ``end_s`` its end [s]."""

    def __init__(self) -> None:
        self._parts: list[Traces] = []
        self.shown: Traces | None = None
        self.end_s = -math.inf

    def add(self, new: Traces) -> Traces | None:
        """Add what is new of some traces; return it behind the last second; None: nothing is."""
        if self.shown is not None and len(ends := ends_s(self.shown)):
            new = since(new, float(ends[-1]) + ROUNDED_S)
        if not len(new.time_s):
            return None
        self._parts.append(new)
        both = new if self.shown is None else joined([self.shown, new])
        self.end_s = float(new.time_s[-1])
        late = float(both.time_s[0]) < self.end_s - 1.25 * SHOWN_S  # not at every call
        self.shown = since(both, self.end_s - SHOWN_S) if late else both
        return both

    def judged(self, start_s: float) -> list[Traces]:
        """Return what is kept of the time from ``start_s`` on, as one; nothing where that is."""
        if not self._parts:
            return []
        self._parts = [since(joined(self._parts), self.end_s - SPAN_S)]
        found = since(self._parts[0], start_s)
        return [found] if len(ends_s(found)) else []


class Tape:
    """All of a session. ``packets``, by link: number, sent, arrived [s], fate; ``zero_ns`` is when
    time begins, None before.
    """

    def __init__(self, scenario: Scenario, *, live: bool) -> None:
        self._source = "live" if live else "simulated"
        self.users = {user.name: Newest[UserTraces]() for user in scenario.users}
        self.server = Newest[ServerTraces]()
        self.packets: list[Array] = [np.empty((0, 4)) for _ in range(2 * len(self.users))]
        self.zero_ns: int | None = None

    @property
    def end_s(self) -> float:
        """Time of the newest tick [s]."""
        return max(max(user.end_s for user in self.users.values()), 0.0)

    def zero(self, time_ns: int) -> int:
        """Return when time begins on the nodes' clock [ns]: at the first time asked with."""
        if self.zero_ns is None:
            self.zero_ns = time_ns
        return self.zero_ns

    def add_packets(self, link: int, packets: Array) -> None:
        """Add packets of a link; forget those that were sent before the span."""
        both = np.concatenate([self.packets[link], packets])
        self.packets[link] = both[both[:, 1] > self.end_s - SPAN_S]

    def shown(self) -> SessionTraces:
        """Return the newest second."""
        shown = (user.shown for user in self.users.values())
        known = [each for each in shown if each is not None and len(each.block_time_s)]
        return self._session(known, self.server.shown)

    def judged(self, scenario: Scenario, start_s: float) -> SessionTraces:
        """Return what is kept of the time from ``start_s`` on, also of the links."""
        users = [traces for user in self.users.values() for traces in user.judged(start_s)]
        found = self._session(users, next(iter(self.server.judged(start_s)), None))
        for link, rows in enumerate(self.packets):
            came = rows[np.isfinite(rows[:, 2]) & (rows[:, 1] > start_s)]
            user, count, none = scenario.users[link // 2], len(came), np.zeros((len(came), 1))
            topic = f"/{user.name}/wave_down" if link % 2 else f"/server/{user.name}/wave_up"
            due_s = scenario.server.period_s if link % 2 else user.master.frame_s
            found.packets[topic] = PacketTraces(
                topic=topic,
                time_s=came[:, 2],
                epoch=np.zeros(count, dtype=np.uint64),
                seq=came[:, 0].astype(np.int64),
                sent_ns=np.zeros(count, dtype=np.int64),
                period_s=np.full(count, due_s),
                energy=np.zeros(count),
                orientation=none[:, :0],
                **dict.fromkeys(("wave", "integral", "position"), none),
            )
        return found

    def _session(self, users: list[UserTraces], server: ServerTraces | None) -> SessionTraces:
        end_s = max((float(user.time_s[-1]) + user.tick_s for user in users), default=0.0)
        late = {} if server is None else {"server_lateness_s": server.looked_ns * 1e-9}
        return SessionTraces(self._source, end_s, users, server, metadata=late)
