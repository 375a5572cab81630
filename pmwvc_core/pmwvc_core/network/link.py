# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What happens to the packets of one direction: delay, jitter, loss, duplication, a slow line.

The order of things: a packet is lost on entry, or waits for the serial line of the rate limit
(and is dropped where too many wait), then travels for its delay. Payloads are never looked into.
Time is an argument; all times are integer nanoseconds of one clock.
"""

from collections import deque
from collections.abc import Sequence
from statistics import NormalDist
from typing import Any

import numpy as np

from pmwvc_core.network.delay_trace import DelayTrace, load_delay_trace
from pmwvc_core.network.in_flight import Cause, Fate, FateKind, Transit
from pmwvc_core.params import LinkParams

STANDARD_NORMAL = NormalDist()


def stream_of(seed: int, user: int, direction: int) -> tuple[int, int, int]:
    """Return the seed of one direction (0 up, 1 down) of one user's link: independent streams."""
    return seed, user, direction


class Link(Transit):
    """One direction of a network link.

    Every packet takes the same four random numbers (lost?, copied?, jitter, jitter of the copy)
    whatever the settings: the n-th packet meets the same luck under any of them.

    Parameters
    ----------
    params
        The settings.
    seed
        Of the random numbers; see :func:`stream_of`.
    """

    def __init__(self, params: LinkParams, *, seed: int | Sequence[int]) -> None:
        super().__init__()
        self._rng = np.random.default_rng(seed)
        self._last_due_ns = 0  # latest of all that went in
        self._line_free_ns = 0
        self._starts_ns: deque[int] = deque()  # when each waiting packet gets the line
        self._first_ns: int | None = None
        self.configure(params)

    def configure(self, params: LinkParams) -> None:
        """Change the settings from now on; packets under way keep their times.

        Raises
        ------
        RecordingError
            If a delay trace is asked for and its file cannot be used; the settings stay.
        """
        trace = None
        if params.jitter == "trace":
            trace = load_delay_trace(params.trace_file, params.trace_scale)
        self._trace: DelayTrace | None = trace
        self.params = params

    def send(self, payload: Any, now_ns: int, *, size_bytes: int = 140) -> list[Fate]:
        """Put a packet in; return its fate, and one for every extra copy."""
        if self._first_ns is None:
            self._first_ns = now_ns
        self.counters.in_count += 1
        lost, copied, jitter, jitter_of_copy = self._rng.random(4).tolist()
        if lost < self.params.loss:
            self.counters.lost += 1
            return [self._fate(now_ns, FateKind.LOST, Cause.LOSS, size_bytes)]
        fate = self._fate(now_ns, FateKind.DELIVERED, Cause.NONE, size_bytes)
        fates = [self._travel(payload, fate, jitter)]
        if copied < self.params.duplicate:
            self.counters.duplicated += 1
            copy = self._fate(now_ns, FateKind.DUPLICATE, Cause.DUPLICATION, size_bytes)
            fates.append(self._travel(payload, copy, jitter_of_copy))
        return fates

    def _fate(self, now_ns: int, kind: FateKind, cause: Cause, size: int) -> Fate:
        return Fate(self.counters.in_count, now_ns, 0, kind, cause, size)

    def _travel(self, payload: Any, fate: Fate, luck: float) -> Fate:
        """Send a packet or copy over the line and through the delay, or drop it."""
        start_ns = self._through_line(fate)
        if start_ns is None:
            self.counters.dropped += 1
            fate.kind, fate.cause = FateKind.DROPPED_QUEUE, Cause.QUEUE_FULL
            return fate
        due_ns = start_ns + self._delay_ns(fate.time_in_ns, luck)
        if self.params.keep_order:
            due_ns = max(due_ns, self._last_due_ns)
        self._last_due_ns = max(due_ns, self._last_due_ns)
        self._enter(payload, fate, due_ns)
        return fate

    def _through_line(self, fate: Fate) -> int | None:
        """Return when the last bit is on its way; None where too many packets wait already."""
        rate, now_ns = self.params.rate_limit_bps, fate.time_in_ns
        if rate <= 0.0:
            return now_ns
        while self._starts_ns and self._starts_ns[0] <= now_ns:
            self._starts_ns.popleft()
        if len(self._starts_ns) >= self.params.queue_packets:
            return None
        start_ns = max(now_ns, self._line_free_ns)
        self._starts_ns.append(start_ns)
        self._line_free_ns = start_ns + round(8e9 * fate.size / rate)
        return self._line_free_ns

    def _delay_ns(self, now_ns: int, luck: float) -> int:
        params = self.params
        delay_s = params.delay_s
        if params.jitter == "uniform":
            delay_s += params.jitter_s * (2.0 * luck - 1.0)
        elif params.jitter == "normal":
            delay_s += params.jitter_s * STANDARD_NORMAL.inv_cdf(max(luck, 1e-17))
        delay_ns = max(0, round(delay_s * 1e9))
        if self._trace is not None and self._first_ns is not None:
            delay_ns += self._trace.at(now_ns - self._first_ns)
        return delay_ns
