# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Queues: a serial line of limited rate, and slots as on a shared radio channel.

The instants of the slots are a renewal process of the link, whatever the packets do: its intervals
are evenly spread from ``slot_min_s`` to ``slot_max_s``. A packet comes out at the first instant at
which it is due and there is room in the slot.
"""

import bisect
from collections import deque

from pmwvc_core.network.effects.record import Effect, LinkEffect, Uniform, linux_effect, not_above
from pmwvc_core.network.in_flight import Fate
from pmwvc_core.params import LinkParams


def line_bytes(size: int, params: LinkParams) -> int:
    """Return what a packet of a size takes on the line, headers and whole cells [byte]."""
    size += params.rate_overhead_bytes
    if params.rate_cell_bytes:
        cells = -(-size // params.rate_cell_bytes)
        size = cells * (params.rate_cell_bytes + params.rate_cell_overhead_bytes)
    return size


class Drain:
    """The queue that other settings leave behind.

    Behind packets that earlier settings keep long, those of faster ones do not come out all at
    once with the last of them but twice as fast as they went in, until none waits.
    """

    def __init__(self) -> None:
        self._in_ns = 0  # when the last packet went in
        self.begin()

    def begin(self) -> None:
        """Let the packets behind the queue of now come out in turn."""
        self._behind = True
        self._gap_ns = 0  # between the last two that went in

    def in_turn_ns(self, in_ns: int, latest_ns: int, due_ns: int) -> int:
        """Return when a packet comes out that is due, and behind the latest one."""
        gap_ns = in_ns - self._in_ns
        if self._behind:
            self._behind = due_ns < latest_ns + gap_ns // 2
            due_ns = max(due_ns, latest_ns + min(gap_ns, self._gap_ns) // 2)
        if gap_ns:
            self._in_ns, self._gap_ns = in_ns, gap_ns
        return due_ns


class SerialLine(Effect):
    """Send one packet after the other, 8 size/rate each; drop those that find the queue full."""

    def __init__(self, params: LinkParams, uniform: Uniform) -> None:
        self._drain = Drain()
        self._free_ns = 0
        self._waiting: deque[tuple[int, int]] = deque()  # when it gets the line, bytes
        self._bytes = 0  # of those that wait
        super().__init__(params, uniform)

    def configure(self, params: LinkParams) -> None:
        """Take another rate; packets of the earlier one may wait."""
        super().configure(params)
        self._drain.begin()

    def departs_ns(self, fate: Fate, ready_ns: int) -> int | None:
        """Return when the last bit is on its way; None where too much waits already."""
        params, waiting = self.params, self._waiting
        while waiting and waiting[0][0] <= ready_ns:
            self._bytes -= waiting.popleft()[1]
        size = line_bytes(fate.size, params)
        start_ns = max(ready_ns, self._free_ns)
        waits = start_ns > ready_ns
        if len(waiting) >= params.queue_packets:
            return None
        if waits and params.queue_bytes and self._bytes + size > params.queue_bytes:
            return None
        waiting.append((start_ns, size))
        self._bytes += size
        left_ns = start_ns + round(8e9 * size / params.rate_limit_bps)
        self._free_ns = self._drain.in_turn_ns(fate.time_in_ns, self._free_ns, left_ns)
        return self._free_ns


RATE_LIMIT = LinkEffect(
    name="rate_limit",
    words="Packets wait for a line of limited rate.",
    make=SerialLine,
    linux=True,
    switch=("rate_limit_bps", 0),
    active=lambda params: params.rate_limit_bps > 0.0,
    random=False,
    amount=lambda params: f"rate limit of {params.rate_limit_bps:g} bit/s",
    label=lambda params: f"{float(params.rate_limit_bps / 1e3):.4g} kbit/s",
)


LEAST_NS = 1000  # between two instants
KEPT_NS = 200_000_000_000  # how long an instant is remembered; longer than any delay


class Slots(Effect):
    """Let packets out at the instants of the slots."""

    def __init__(self, params: LinkParams, uniform: Uniform) -> None:
        super().__init__(params, uniform)
        self._number = 0  # of slots so far
        self._ends_ns: list[int] = []
        self._held: dict[int, list[int]] = {}  # packets and bytes by instant

    def arrives_ns(self, fate: Fate, due_ns: int) -> int:
        """Return the first instant with room, at ``due_ns`` or later."""
        self._reach(due_ns)
        index = bisect.bisect_left(self._ends_ns, due_ns)
        params = self.params
        while True:
            if index == len(self._ends_ns):
                self._reach(self._ends_ns[-1] + 1)
            instant_ns = self._ends_ns[index]
            held = self._held.setdefault(instant_ns, [0, 0])
            fits = not params.slot_packets or held[0] < params.slot_packets
            if fits and params.slot_bytes and held[0]:
                fits = held[1] + fate.size <= params.slot_bytes
            if fits:
                held[0] += 1
                held[1] += fate.size
                return instant_ns
            index += 1

    def _reach(self, time_ns: int) -> None:
        """Draw instants until one is at this time or later; forget those long past."""
        ends = self._ends_ns
        last_ns = ends[-1] if ends else self.begin_ns
        low_s, high_s = self.params.slot_min_s, self.params.slot_max_s
        while not ends or last_ns < time_ns:
            self._number += 1
            step_s = low_s + (high_s - low_s) * self.of_event(self._number)
            last_ns += max(round(step_s * 1e9), LEAST_NS)
            ends.append(last_ns)
        if ends[0] < time_ns - KEPT_NS:
            old = bisect.bisect_left(ends, time_ns - KEPT_NS // 2)
            for instant_ns in ends[:old]:
                self._held.pop(instant_ns, None)
            del ends[:old]


def mean_wait_s(params: LinkParams) -> float:
    """Return the mean time to the next instant from any time [s]: E[L^2] / (2 E[L])."""
    low, high = params.slot_min_s, params.slot_max_s
    return (low * low + low * high + high * high) / (3.0 * (low + high))


SLOTS = linux_effect(
    name="slots",
    words="Packets come out only in slots, several at once.",
    make=Slots,
    active=lambda params: params.slot_max_s > 0.0,
    spreads=True,
    spread_s=lambda params: float(params.slot_max_s),
    mean_s=mean_wait_s,
    amount=lambda params: (
        f"slots {params.slot_min_s * 1e3:g} to {params.slot_max_s * 1e3:g} ms apart"
    ),
    label=lambda params: f"slots to {float(params.slot_max_s * 1e3):.4g} ms",
    conflict=lambda params: not_above(params, "slot_min_s", "slot_max_s"),
)
