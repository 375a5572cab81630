# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Queues of a link: a serial line of limited rate, slots as on a shared radio channel, and the
order of packets. Times are integer nanoseconds. The instants of the slots are a renewal process of
the link: intervals evenly spread from ``slot_min_s`` to ``slot_max_s``.
"""

import bisect
from collections import deque
from collections.abc import Callable

from pmwvc_core.network.in_flight import Fate
from pmwvc_core.params import LinkParams

LEAST_NS = 1000  # between two instants of slots


class Drain:
    """The queue that other settings leave behind: packets of faster ones come out behind it twice
    as fast as they went in, until none waits.
    """

    def __init__(self) -> None:
        self._in_ns = 0  # when the last packet went in
        self.latest_ns = 0  # when the latest one comes out
        self.begin()

    def begin(self) -> None:
        """Let the packets behind the queue of now come out in turn: settings have changed."""
        self._behind = True
        self._gap_ns = 0  # between the last two that went in

    def in_turn_ns(self, in_ns: int, due_ns: int) -> int:
        """Return when a packet comes out that is due, and behind the latest one."""
        gap_ns = in_ns - self._in_ns
        if self._behind:
            self._behind = due_ns < self.latest_ns + gap_ns // 2
            due_ns = max(due_ns, self.latest_ns + min(gap_ns, self._gap_ns) // 2)
        if gap_ns:
            self._in_ns, self._gap_ns = in_ns, gap_ns
        return due_ns


class Order(Drain):
    """The order of packets, kept where ``keep_order`` is set, also against earlier settings."""

    def arrives_ns(self, p: LinkParams, fate: Fate, due_ns: int) -> int:
        """Return the time of the latest packet before, or its turn after it, if that is later."""
        in_turn_ns = self.in_turn_ns(fate.time_in_ns, due_ns)
        self.latest_ns = max(in_turn_ns if p.keep_order else due_ns, self.latest_ns)
        return self.latest_ns if p.keep_order else due_ns


class SerialLine(Drain):
    """One packet after the other, 8 size/rate each; those that find the queue full are dropped."""

    def __init__(self) -> None:
        super().__init__()
        self._waiting: deque[tuple[int, int]] = deque()  # when it gets the line, bytes
        self._bytes = 0  # of those that wait

    def departs_ns(self, p: LinkParams, fate: Fate, ready_ns: int) -> int | None:
        """Return when the last bit is on its way; None where too much waits already."""
        waiting = self._waiting
        while waiting and waiting[0][0] <= ready_ns:
            self._bytes -= waiting.popleft()[1]
        size = fate.size + p.rate_overhead_bytes
        start_ns = max(ready_ns, self.latest_ns)
        too_many = p.queue_bytes and self._bytes + size > p.queue_bytes
        if len(waiting) >= p.queue_packets or (start_ns > ready_ns and too_many):
            return None
        waiting.append((start_ns, size))
        self._bytes += size
        left_ns = start_ns + round(8e9 * size / p.rate_limit_bps)
        self.latest_ns = self.in_turn_ns(fate.time_in_ns, left_ns)
        return self.latest_ns


class Slots:
    """The instants at which packets come out; ``draw`` gives the random number of the n-th."""

    def __init__(self, draw: Callable[[int], float]) -> None:
        self._draw = draw
        self._number = 0  # of slots so far
        self._ends_ns: list[int] = []

    def arrives_ns(self, p: LinkParams, fate: Fate, due_ns: int, begin_ns: int) -> int:
        """Return the first instant at ``due_ns`` or later; forget those before it went in."""
        ends = self._ends_ns
        last_ns = ends[-1] if ends else begin_ns
        while not ends or last_ns < due_ns:
            self._number += 1
            u = self._draw(self._number)
            step_s = p.slot_min_s + (p.slot_max_s - p.slot_min_s) * u
            last_ns += max(round(step_s * 1e9), LEAST_NS)
            ends.append(last_ns)
        del ends[: bisect.bisect_left(ends, fate.time_in_ns)]
        return ends[bisect.bisect_left(ends, due_ns)]
