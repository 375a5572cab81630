# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Emulation as tc-netem of Linux does it, faults included: order of decisions and arithmetic.

Of Linux 6: copying is decided before loss, and a packet that is both is neither; a copy is judged
again; correlated numbers are ``(1 - rho) U + rho last`` in whole numbers of 32 bit, which are not
evenly spread; the low bits of such a number choose the delay, so that its correlation is lost; a
table ends at four standard deviations; the rate acts after the delay. Random numbers are not those
of the kernel but the link's own stream.
"""

import heapq
import math
from functools import lru_cache

import numpy as np

from pmwvc_core.network.distributions import DISTRIBUTIONS, TAIL, drawn, normal
from pmwvc_core.network.effects.queues import line_bytes
from pmwvc_core.network.in_flight import Cause, Fate, FateKind
from pmwvc_core.network.streams import Stream
from pmwvc_core.numeric import Array
from pmwvc_core.params import LinkParams

FULL = 1 << 32
SCALE = 8192  # of a table entry: one standard deviation
ENTRIES = 4096
LIMIT = 1000  # packets, where there is no rate limit
DUPLICATE, LOSS, LOSS_TOO, CORRUPT, BIT, REORDER, DELAY, SLOT = range(8)  # numbers of a packet
GOOD, WITHIN_BURST, IN_BURST, ISOLATED = 1, 2, 3, 4


def as_u32(probability: float) -> int:
    """Return a probability as a whole number of 32 bit."""
    return round(probability * (FULL - 1))


@lru_cache(maxsize=16)
def table_of(params: LinkParams) -> tuple[int, ...]:
    """Return the quantiles of the jitter in 1/8192 of a deviation from the mean, 16 bit each."""
    distribution = DISTRIBUTIONS[params.jitter]
    if distribution.linux:
        return linux_table(params.jitter)
    quantile, (mean, deviation) = distribution.quantile(params), distribution.moments(params)
    if deviation <= 0.0:
        return (0,)
    values = [(quantile((k + 0.5) / ENTRIES) - mean) / deviation * SCALE for k in range(ENTRIES)]
    return _whole(np.array(values))


def linux_table(name: str) -> tuple[int, ...]:
    """Return a table that comes with tc; Pareto has a standard deviation of 0.82 there, not 1."""
    k = np.arange(ENTRIES)
    bell = np.rint(SCALE * np.array([normal((4.0 * each + 0.5) / 16384.0) for each in k]))
    tail = np.rint(((1.0 - k / ENTRIES) ** (-1.0 / TAIL) - 1.5) * (4.0 / 3.0) * SCALE)
    tail = np.minimum(tail, 32767)
    mixed = np.trunc((bell + 3.0 * tail) / 4.0)
    return _whole({"normal": bell, "pareto": tail, "paretonormal": mixed}[name])


def _whole(values: Array) -> tuple[int, ...]:
    return tuple(int(value) for value in np.clip(np.rint(values), -32768, 32767))


class SlotGate:
    """The slots of tc-netem: the next one is drawn once the queue meets a gate that is past."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._number = 0
        self._next_ns = -1  # past for any packet

    def configure(self, params: LinkParams) -> None:
        """Take settings; the next slot stays."""
        self._params = params
        self._refill()

    def opens_ns(self, due_ns: int) -> int:
        """Return when the head of the queue passes, which is due at ``due_ns``."""
        if self._next_ns < due_ns:
            self._draw(due_ns)
        return max(due_ns, self._next_ns)

    def passed(self, size: int, now_ns: int) -> None:
        """Note that a packet of a size [byte] has passed."""
        self._packets -= 1
        self._bytes -= size
        if self._packets <= 0 or self._bytes <= 0:
            self._draw(now_ns)

    def _draw(self, now_ns: int) -> None:
        low, high = (round(s * 1e9) for s in (self._params.slot_min_s, self._params.slot_max_s))
        self._number += 1
        each = Fate(self._number, 0, 0, FateKind.DELIVERED, Cause.NONE, 0)
        self._next_ns = now_ns + low + (int(self._stream(each, SLOT) * FULL) * (high - low) >> 32)
        self._refill()

    def _refill(self) -> None:
        self._packets = self._params.slot_packets or FULL
        self._bytes = self._params.slot_bytes or FULL


class NetemMode:
    """The state of the discipline of one link."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._last = dict.fromkeys((DUPLICATE, LOSS, CORRUPT, REORDER, DELAY), 0)
        self._state = GOOD
        self._counter = 0
        self._inside: list[int] = []  # heap of the times at which packets leave
        self._slots = SlotGate(stream)
        self.gate: SlotGate | None = None

    def configure(self, params: LinkParams) -> None:
        """Take settings; states and numbers stay."""
        self._params = params
        self.gate = None
        if not params.as_linux:
            return
        if params.slot_max_s:
            self._slots.configure(params)
            self.gate = self._slots
        self._table: tuple[int, ...] | None = None
        self._mean_ns, self._size_ns = round(params.delay_s * 1e9), 0
        law = drawn(params)
        if law is not None and law.half_width:
            self._size_ns = round(params.jitter_s * 1e9)
        elif law is not None:
            mean_s, deviation_s = law.moments(params)
            self._mean_ns += round(mean_s * 1e9)
            self._size_ns = round(deviation_s * 1e9)
            self._table = table_of(params)

    def judge(self, fate: Fate, *, may_copy: bool) -> tuple[bool, bool]:
        """Return whether a packet is lost, and whether it is copied; not both."""
        p = self._params
        copied = False
        if may_copy and p.duplicate:
            number = self._number(fate, DUPLICATE, p.duplicate_correlation)
            copied = as_u32(p.duplicate) >= number
        lost = self._loses(fate)
        return lost and not copied, copied and not lost

    def corrupts(self, fate: Fate) -> float | None:
        """Return where a packet is corrupted; None: nowhere."""
        p = self._params
        if not p.corrupt:
            return None
        hit = as_u32(p.corrupt) >= self._number(fate, CORRUPT, p.corrupt_correlation)
        return self._stream(fate, BIT) if hit else None

    def full(self, now_ns: int) -> bool:
        """Tell whether the queue, with all that waits for its delay, takes no more."""
        inside = self._inside
        while inside and inside[0] <= now_ns:
            heapq.heappop(inside)
        return len(inside) >= (
            self._params.queue_packets if self._params.rate_limit_bps else LIMIT
        )

    def send_ns(self, fate: Fate) -> int:
        """Return when a packet leaves the queue."""
        p, now_ns = self._params, fate.time_in_ns
        if p.reorder and self._counter >= p.reorder_gap - 1:
            number = self._number(fate, REORDER, p.reorder_correlation)
            if as_u32(p.reorder) >= number:
                self._counter = 0
                return now_ns
        delay_ns = self._delay_ns(fate)
        if p.rate_limit_bps:
            last_ns = max(self._inside, default=0)
            if last_ns > now_ns:
                delay_ns = max(0, delay_ns - (last_ns - now_ns))
                now_ns = last_ns
            delay_ns += int(8e9 * line_bytes(fate.size, p) / p.rate_limit_bps)
        self._counter += 1
        send_ns = now_ns + delay_ns
        heapq.heappush(self._inside, send_ns)
        return max(send_ns, fate.time_in_ns)

    def _delay_ns(self, fate: Fate) -> int:
        size = self._size_ns
        if not size:
            return self._mean_ns
        number = self._number(fate, DELAY, self._params.jitter_correlation)
        if self._table is None:
            return number % (2 * size) + self._mean_ns - size
        entry = self._table[number % len(self._table)]
        part = (size % SCALE) * entry
        part += SCALE // 2 if part >= 0 else -(SCALE // 2)
        return math.trunc(part / SCALE) + (size // SCALE) * entry + self._mean_ns

    def _number(self, fate: Fate, which: int, rho: float) -> int:
        """Return a number of 32 bit, correlated with the one before."""
        value = int(self._stream(fate, which) * FULL)
        if not rho:
            return value
        weight = as_u32(rho) + 1
        value = (value * (FULL - weight) + self._last[which] * weight) >> 32
        self._last[which] = value
        return value

    def _loses(self, fate: Fate) -> bool:
        p = self._params
        if p.markov_p13 or p.markov_p14:
            return self._four_states(as_u32(self._stream(fate, LOSS)))
        if p.ge_p or p.ge_good:
            change, chance = (self._stream(fate, each) for each in (LOSS, LOSS_TOO))
            if self._state == GOOD:
                self._state = WITHIN_BURST if change < p.ge_p else GOOD
                return chance < p.ge_good
            self._state = GOOD if change < p.ge_r else WITHIN_BURST
            return chance < p.ge_bad
        return bool(p.loss) and as_u32(p.loss) >= self._number(fate, LOSS, p.loss_correlation)

    def _four_states(self, number: int) -> bool:
        p = self._params
        p13, p31, p32, p23, p14 = (
            as_u32(each)
            for each in (p.markov_p13, p.markov_p31, p.markov_p32, p.markov_p23, p.markov_p14)
        )
        if self._state == GOOD:
            if number < p14:
                self._state = ISOLATED
            elif p14 < number < p13 + p14:
                self._state = IN_BURST
        elif self._state == WITHIN_BURST:
            self._state = IN_BURST if number < p23 else WITHIN_BURST
        elif self._state == IN_BURST:
            if number < p32:
                self._state = WITHIN_BURST
            elif p32 < number < p31 + p32:
                self._state = GOOD
        else:
            self._state = GOOD
        return self._state in (IN_BURST, ISOLATED)
