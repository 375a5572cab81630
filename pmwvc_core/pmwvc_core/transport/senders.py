# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Senders that a receiver refuses, and what makes it believe one of them.

A receiver follows one sender (one epoch) at a time. Another sender becomes credible when it sends
``CREDIBLE`` packets in ascending order within the time of silence, or within what they stand for
where that is longer: a stray packet now and then never does. A sender whose packets look old (a
former epoch, lower numbers, an earlier clock) needs ``INSIST`` packets in ascending order. At most
``REMEMBERED`` senders are kept, so that a flood of random epochs costs no memory; the one whose
last packet is oldest is dropped first.

Not here: whether the sender that is followed has gone silent (``receiver``).
"""

from collections import deque
from typing import TypeVar

T = TypeVar("T")

CREDIBLE = 3
INSIST = 8
REMEMBERED = 16


class Run:
    """Packets of one sender in ascending order; ``CREDIBLE`` of them have to come within
    ``window_ns`` [ns], or within the time of as many packets.
    """

    __slots__ = ("_seq", "_span_ns", "_times_ns", "_window_ns", "count")

    def __init__(self, window_ns: int) -> None:
        self.count = 0
        self._window_ns = self._span_ns = window_ns
        self._seq = 0
        self._times_ns: deque[int] = deque(maxlen=CREDIBLE)

    def add(self, seq: int, now_ns: int, period_s: float) -> None:
        """Take a packet that stands for so long; one that is not newer than the last begins a new
        run.
        """
        self._span_ns = max(self._window_ns, round(CREDIBLE * period_s * 1e9))
        if seq <= self._seq:
            self.count = 0
            self._times_ns.clear()
        self.count += 1
        self._seq = seq
        self._times_ns.append(now_ns)

    @property
    def credible(self) -> bool:
        """Tell whether the last packets came as fast as a sender's do."""
        times = self._times_ns
        return len(times) == CREDIBLE and times[-1] - times[0] <= self._span_ns


class Senders:
    """The senders refused, by epoch; see the module."""

    def __init__(self, window_ns: int) -> None:
        self._window_ns = window_ns
        self.runs: dict[int, Run] = {}
        self.refused: dict[int, int] = {}  # packets by epoch, of those last refused

    def add(self, epoch: int, seq: int, now_ns: int, period_s: float) -> Run:
        """Take a packet that is refused unless its run makes it believed; return that run."""
        run = self.runs.pop(epoch, None) or Run(self._window_ns)
        run.add(seq, now_ns, period_s)
        _keep(self.runs, epoch, run)
        return run

    def followed(self, epoch: int, seq: int, now_ns: int, period_s: float) -> Run | None:
        """Return the run of a sender that is followed from now on; None where it is believed."""
        run = self.runs.pop(epoch, None)
        if run is None:
            run = Run(self._window_ns)
            run.add(seq, now_ns, period_s)
        return None if run.credible or run.count >= INSIST else run

    def refuse(self, epoch: int) -> None:
        """Count a packet of another sender."""
        _keep(self.refused, epoch, self.refused.pop(epoch, 0) + 1)

    def forget(self, epoch: int | None = None) -> None:
        """Let the run of one sender, or of all, begin anew: the one followed has sent."""
        if not self.runs:
            return
        if epoch is None:
            self.runs.clear()
        else:
            self.runs.pop(epoch, None)


def _keep(known: dict[int, T], epoch: int, value: T) -> None:
    known[epoch] = value
    if len(known) > REMEMBERED:
        del known[next(iter(known))]
