# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock of a loop: absolute deadlines ``k * period + phase`` of the monotonic clock, so that
lateness does not add up and loops of a machine keep their phases; and counts of how they were met.
"""

import ctypes
import errno
import os
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

_NS_PER_S = 1_000_000_000
_TIMER_ABSTIME = 1
_libc = ctypes.CDLL(None)


class _Timespec(ctypes.Structure):
    _fields_ = (("tv_sec", ctypes.c_long), ("tv_nsec", ctypes.c_long))


def sleep_until(deadline_ns: int) -> None:
    """Sleep until the monotonic clock shows a time, whatever signals come meanwhile."""
    until = _Timespec(*divmod(max(deadline_ns, 0), _NS_PER_S))
    clock = time.CLOCK_MONOTONIC
    while code := _libc.clock_nanosleep(clock, _TIMER_ABSTIME, ctypes.byref(until), None):
        if code != errno.EINTR:
            raise OSError(code, os.strerror(code))


@dataclass(frozen=True, slots=True)
class Tick:
    """One wake-up of a loop. ``grid`` counts deadlines since the clock's origin, ``lateness_ns``
    from ``due_ns``, without the ``skipped`` periods before it.
    """

    grid: int
    due_ns: int
    woke_ns: int
    lateness_ns: int
    skipped: int


class Pacer:
    """Absolute deadlines for one loop, one call of ``wait`` per tick.

    ::

        due[0] = first point of {k * period_ns + phase_ns} after the first call
        due[n] = due[n - 1] + period_ns                                  (nothing skipped)
        wake[n] >= max(due[n], wake[n - 1] + period_ns / 2)

    A late loop runs every tick, half a period apart or more, until it is back on its grid. When it
    wakes later than ``recover_ns``, the deadlines that passed are skipped and counted, and the
    tick stands for the newest one. ``clock`` is monotonic [ns]; ``sleep`` sleeps until it shows a
    value.
    """

    def __init__(
        self, period_ns: int, *, phase_ns: int = 0, recover_ns: int = 25_000_000,
        clock: Callable[[], int] = time.monotonic_ns, sleep: Callable[[int], None] = sleep_until,
    ) -> None:  # fmt: skip
        self.period_ns, self._phase_ns, self._recover_ns = period_ns, phase_ns, recover_ns
        self._clock, self._sleep = clock, sleep
        self._due_ns: int | None = None
        self._earliest_ns = 0

    def wait(self) -> Tick:
        """Sleep until the next tick may run and return how it began."""
        period = self.period_ns
        now = self._clock()
        if self._due_ns is None:
            due = now - (now - self._phase_ns) % period + period
        else:
            due = self._due_ns + period
        target = max(due, self._earliest_ns)
        if now < target:
            self._sleep(target)
            now = self._clock()
        late = now - due
        skipped = late // period if late > self._recover_ns else 0
        due += skipped * period
        self._due_ns = due
        self._earliest_ns = now + (period + 1) // 2
        return Tick(due // period, due, now, now - due, skipped)

    def retime(self, period_ns: int) -> None:
        """Go on with another period: the next deadline is the first of its grid after the last."""
        if self._due_ns is not None:
            self._due_ns -= (self._due_ns - self._phase_ns) % period_ns
        self.period_ns = period_ns

    def ticks(self, stop: threading.Event) -> Iterator[Tick]:
        """Yield ticks until ``stop`` is set; the sleep under way is still slept to its end."""
        while not stop.is_set():
            tick = self.wait()
            if stop.is_set():
                return
            yield tick


@dataclass(slots=True)
class Health:
    """Ticks, lateness, computing time; a reader swaps in a fresh one, the loop never waits."""

    ticks: int = 0
    late_sum_ns: int = 0
    late_max_ns: int = 0
    compute_sum_ns: int = 0
    compute_max_ns: int = 0

    def add(self, late_ns: int, compute_ns: int) -> None:
        """Count one tick."""
        self.ticks += 1
        self.late_sum_ns += late_ns
        self.compute_sum_ns += compute_ns
        self.late_max_ns = max(self.late_max_ns, late_ns)
        self.compute_max_ns = max(self.compute_max_ns, compute_ns)
