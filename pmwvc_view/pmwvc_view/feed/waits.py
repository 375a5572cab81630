# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The time that went by in waiting for late packets while a session runs.

The criterion is the report's (:mod:`pmwvc_analysis.traces.arrivals`), from when packets left their
links: more than half a frame late counts.
"""

import itertools
from collections import deque
from collections.abc import Sequence

import numpy as np

from pmwvc_analysis.traces.arrivals import LATE
from pmwvc_analysis.traces.holes import without
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view.feed.traces import NS

KEPT = 500  # waits of a link


class Waits:
    """The waits of all links, up and down for each user; none where frames are not known."""

    def __init__(self, scenario: Scenario | None, users: Sequence[str]) -> None:
        known = {user.name: user for user in scenario.users} if scenario else {}
        self._due_ns: list[float] = []
        for name in users:
            up_s = known[name].master.frame_s if name in known else np.inf
            down_s = scenario.server.period_s if scenario else np.inf
            self._due_ns += [up_s * NS, down_s * NS]
        self._newest_ns = [-1] * len(self._due_ns)
        self._waits = [deque[tuple[float, float]](maxlen=KEPT) for _ in self._due_ns]

    def packets(self, link: int, out_ns: Array) -> None:
        """Take in when packets left a link [ns] (0: never)."""
        times = np.sort(out_ns[out_ns > 0]).astype(np.int64).tolist()
        before = self._newest_ns[link]
        for time_ns in times:
            if before >= 0 and time_ns - before > (1.0 + LATE) * self._due_ns[link]:
                self._waits[link].append((before / NS, time_ns / NS))
            before = max(before, time_ns)
        self._newest_ns[link] = before

    def ratio(self, begin_s: float, end_s: float) -> float:
        """Return the largest ratio, over the links, of a time that went by in waiting."""
        waited = [
            sum(max(min(end, end_s) - max(begin, begin_s), 0.0) for begin, end in waits)
            for waits in self._waits
        ]
        return max(waited, default=0.0) / (end_s - begin_s)

    def timely(self, begin_s: float, end_s: float) -> list[tuple[float, float]]:
        """Return the stretches of a time, from and until [s], in which nothing waited."""
        return without(itertools.chain.from_iterable(self._waits), begin_s, end_s)
