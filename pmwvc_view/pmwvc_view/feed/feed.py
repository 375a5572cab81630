# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The feed: traces of all nodes, in blocks as they come, to rows of one time line. No ROS.

Rows lie on a grid of the nodes' monotonic clock. A row is made once every node's trace reaches
it, or ``PATIENCE_NS`` later without those that are late; it holds the newest tick of each master
and the newest step of the server at its time, and the extremes of the 1 kHz force since the row
before.
"""

import math
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view.feed.traces import NS, OBJECT, TraceBlock, TraceStep
from pmwvc_view.feed.user import FeedUser
from pmwvc_view.feed.window import Window
from pmwvc_view.protocol.snapshot import NO_PACKETS, PACKET, Layout, Snapshot

PATIENCE_NS = 60_000_000
LONGEST_GAP_NS = NS  # where no trace came for longer, the grid begins anew
DELAYS = 64  # newest packets of a link of which the delay is the mean


class Feed:
    """Rows of a session from its traces, and the window of its newest seconds.

    ``zero_ns`` is the time of the first trace, from which the rows' time counts; None before.
    """

    def __init__(
        self,
        layout: Layout,
        users: Sequence[str],
        *,
        period_ns: int,
        scenario: Scenario | None = None,
    ) -> None:
        self._layout = layout
        self.window = Window(users)
        self._users = {name: FeedUser(layout, name, scenario) for name in users}
        self._every = list(self._users.values())
        self._period_ns = period_ns
        self._steps: deque[TraceStep] = deque()
        self._step: TraceStep | None = None
        self._step_end_ns = -1
        self._due_ns: int | None = None
        self._seq = 0
        self._packets: list[Array] = []
        self._delays = [deque[float](maxlen=DELAYS) for _ in range(2 * len(users))]
        self._object_at = layout.together("object", OBJECT)
        self._late_at = layout.slices["server.lateness"].start
        self.zero_ns: int | None = None
        self.others: dict[str, Any] = {}  # by column: values that come from elsewhere

    def on_master(self, user: str, block: TraceBlock) -> None:
        """Take in a block; an old one is dropped."""
        one = self._users[user]
        if block.end_ns <= one.end_ns:
            return
        self._begin(block.start_ns)
        one.end_ns = block.end_ns
        one.blocks.append(block)
        self.window.block(user, block)
        if block.sums is not None:
            one.accounts.block(block.sums)

    def on_server(self, step: TraceStep) -> None:
        """Take in a step; an old one is dropped."""
        if step.start_ns <= self._step_end_ns:
            return
        self._begin(step.start_ns)
        self._step_end_ns = step.start_ns
        self._steps.append(step)
        for name, sums in step.sums.items():
            if name in self._users:
                self._users[name].accounts.step(sums)
        self.window.step(step)

    def on_packets(self, link: int, columns: Array) -> None:
        """Take in packets of a link, ``(n, 4)``: number, time in and out [ns] (0: never), fate."""
        if self.zero_ns is None or not len(columns):
            return
        self.window.packets(link, columns)
        rows = np.empty((len(columns), len(PACKET)))
        rows[:, 0] = link
        rows[:, 1] = columns[:, 0]
        rows[:, 2] = (columns[:, 1] - self.zero_ns) / NS
        rows[:, 3] = np.where(columns[:, 2] > 0, (columns[:, 2] - self.zero_ns) / NS, math.nan)
        rows[:, 4] = columns[:, 3]
        self._packets.append(rows)
        taken, delays = rows[:, 3] - rows[:, 2], self._delays[link]
        delays.extend(taken[np.isfinite(taken)].tolist())
        if delays:
            self._every[link // 2].delays_s[link % 2] = sum(delays) / len(delays)

    def user(self, name: str) -> FeedUser:
        """Return what is known of a user."""
        return self._users[name]

    def rows(self, now_ns: int) -> list[Snapshot]:
        """Return the rows that are due at a time of the nodes' clock."""
        found: list[Snapshot] = []
        while self._due_ns is not None and self._ready(self._due_ns, now_ns):
            found.append(self._row(self._due_ns))
            self._due_ns += self._period_ns
        return found

    def _begin(self, at_ns: int) -> None:
        if self.zero_ns is None:
            self.zero_ns = self.window.zero_ns = at_ns
        if self._due_ns is None or at_ns > self._due_ns + LONGEST_GAP_NS:
            self._due_ns = at_ns + self._period_ns

    def _ready(self, due_ns: int, now_ns: int) -> bool:
        ends = [one.end_ns for one in self._every] + [self._step_end_ns]
        return min(ends) >= due_ns or (max(ends) >= due_ns and now_ns >= due_ns + PATIENCE_NS)

    def _row(self, due_ns: int) -> Snapshot:
        """Return the row at a time."""
        self._seq += 1
        row = self._layout.row()
        row[:2] = self._seq, (due_ns - (self.zero_ns or 0)) / NS
        late_s = -math.inf
        while self._steps and self._steps[0].start_ns <= due_ns:
            self._step = self._steps.popleft()
            late_s = max(late_s, self._step.lateness_s)
        if self._step is not None:
            row[self._object_at] = self._step.object.ravel()
        if late_s > -math.inf:
            row[self._late_at] = late_s
        others = self.others
        for index, one in enumerate(self._every):
            one.follow_lag(*map(others.get, one.lag_columns))
            one.write(row, due_ns, self._step, index)
        self._layout.set(row, others)
        for one in self._every:
            if one.apart:  # what is kept since joining is no price of the delay
                row[one.lag_at] = math.nan
        packets, self._packets = self._packets, []
        return Snapshot(row, np.concatenate(packets) if packets else NO_PACKETS)
