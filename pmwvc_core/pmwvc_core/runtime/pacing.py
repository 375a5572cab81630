# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock of a loop: absolute deadlines, and the system's help in meeting them.

A deadline is a point ``k * period + phase`` of the monotonic clock and never ``now + period``:
lateness does not add up, and loops of several processes on one machine keep their phases.
Nothing here knows what a tick computes; no control law belongs in this file.
"""

import contextlib
import ctypes
import errno
import gc
import os
import resource
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from pmwvc_core.errors import ParameterError

_NS_PER_S = 1_000_000_000
_TIMER_ABSTIME = 1
_PR_SET_TIMERSLACK = 29
_MCL_CURRENT = 1
_MCL_FUTURE = 2
_libc = ctypes.CDLL(None, use_errno=True)


class _Timespec(ctypes.Structure):
    _fields_ = (("tv_sec", ctypes.c_long), ("tv_nsec", ctypes.c_long))


def sleep_until(deadline_ns: int) -> None:
    """Sleep until the monotonic clock shows ``deadline_ns``; return at once when it already does.

    A signal does not end the sleep: its Python handler runs, then the rest is slept.
    """
    until = _Timespec(*divmod(max(deadline_ns, 0), _NS_PER_S))
    clock = time.CLOCK_MONOTONIC
    while code := _libc.clock_nanosleep(clock, _TIMER_ABSTIME, ctypes.byref(until), None):
        if code != errno.EINTR:
            raise OSError(code, os.strerror(code))


@dataclass(frozen=True, slots=True)
class Tick:
    """One wake-up of a loop.

    ``index`` counts executed ticks from 0, ``grid`` deadlines since the clock's origin: they part
    where deadlines were skipped. ``lateness_ns`` is counted from ``due_ns``, the deadline this
    tick stands for, and so does not hold the ``skipped`` whole periods just before it.
    """

    index: int
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

    A late loop runs every tick; wake-ups stay half a period apart or more until it is back on its
    grid: no burst, no gap. When it wakes later than ``recover_ns``, the deadlines that passed
    meanwhile are skipped and counted, and the tick stands for the newest one. It does not look
    whether the work itself fits the period: a loop that never does skips for ever, and reports it.

    Parameters
    ----------
    period_ns
        Time between two deadlines [ns].
    phase_ns
        Distance of the deadlines from the multiples of the period [ns]; taken modulo the period.
    recover_ns
        Lateness up to which every tick is still run [ns].
    clock, sleep
        The monotonic clock [ns], and what sleeps until it shows a value.
    """

    def __init__(
        self,
        period_ns: int,
        *,
        phase_ns: int = 0,
        recover_ns: int = 25_000_000,
        clock: Callable[[], int] = time.monotonic_ns,
        sleep: Callable[[int], None] = sleep_until,
    ) -> None:
        if period_ns <= 0:
            raise ParameterError(f"period_ns = {period_ns}: must be > 0 ns")
        if recover_ns < 0:
            raise ParameterError(f"recover_ns = {recover_ns}: must be >= 0 ns")
        self.period_ns = period_ns
        self._phase_ns = phase_ns
        self.phase_ns = phase_ns % period_ns
        self.recover_ns = recover_ns
        self.missed = 0
        self._clock = clock
        self._sleep = sleep
        self._index = 0
        self._due_ns: int | None = None
        self._earliest_ns = 0

    def wait(self) -> Tick:
        """Sleep until the next tick may run and return how it began."""
        period = self.period_ns
        now = self._clock()
        if self._due_ns is None:
            due = now - (now - self.phase_ns) % period + period
        else:
            due = self._due_ns + period
        target = max(due, self._earliest_ns)
        if now < target:
            self._sleep(target)
            now = self._clock()
        late = now - due
        skipped = late // period if late > self.recover_ns else 0
        due += skipped * period
        tick = Tick(self._index, due // period, due, now, now - due, skipped)
        self.missed += skipped
        self._index += 1
        self._due_ns = due
        self._earliest_ns = now + (period + 1) // 2
        return tick

    def retime(self, period_ns: int) -> None:
        """Go on with another period: the next deadline is the first of its grid after the last."""
        phase_ns = self._phase_ns % period_ns
        if self._due_ns is not None:
            self._due_ns -= (self._due_ns - phase_ns) % period_ns
        self.period_ns, self.phase_ns = period_ns, phase_ns

    def ticks(self, stop: threading.Event) -> Iterator[Tick]:
        """Yield ticks until ``stop`` is set; the sleep under way is still slept to its end."""
        while not stop.is_set():
            tick = self.wait()
            if stop.is_set():
                return
            yield tick


@dataclass(frozen=True)
class RealTimeReport:
    """The real-time requests that the system granted, and the reason of each refusal."""

    granted: tuple[str, ...] = ()
    refused: dict[str, str] = field(default_factory=dict)

    def __add__(self, other: "RealTimeReport") -> "RealTimeReport":
        """Return a report of the requests of both."""
        return RealTimeReport(self.granted + other.granted, self.refused | other.refused)

    def __str__(self) -> str:
        """Return one line for a log."""
        refused = [f"{name} refused ({reason})" for name, reason in self.refused.items()]
        return "real time: " + "; ".join([*(f"{name} granted" for name in self.granted), *refused])


def hold_memory() -> RealTimeReport:
    """Ask for memory that stays where it is: locked, the garbage collector's survivors frozen.

    Both hold for the whole process, so call this after set-up. It takes up to seconds on a busy
    machine, so call it before a node can be started: nodes that are started together then begin
    together.
    """
    return _asked(
        ("memory lock", _lock_memory),
        ("frozen garbage collector", _freeze_garbage),
    )


def request_real_time(priority: int) -> RealTimeReport:
    """Ask for what makes the calling thread wake in time; a refusal is reported, never raised.

    Timer slack and scheduling class belong to the calling thread, so call this from the loop's own
    thread; threads and processes it starts later do not inherit the class. The threads of the
    middleware, without which no packet comes in, go one step below.

    Parameters
    ----------
    priority
        Priority asked for under SCHED_FIFO, 1 to 99.
    """
    return _asked(
        ("timer slack 1 ns", _set_timer_slack),
        (f"SCHED_FIFO {priority}", lambda: _set_fifo(priority)),
        ("SCHED_FIFO of the middleware", lambda: _set_middleware_fifo(max(priority - 1, 1))),
    )


def request_reception(priority: int) -> RealTimeReport:
    """Ask for a middleware that takes packets in whatever else the machine does; see above.

    For programs without a loop of their own: they may be late, but nothing overflows meanwhile.
    """
    return _asked(("SCHED_FIFO of the middleware", lambda: _set_middleware_fifo(priority)))


def request_priority(priority: int) -> RealTimeReport:
    """Ask for SCHED_FIFO for the calling thread only: it sleeps most of the time, and is not to be
    put aside by ordinary programs when it wakes.
    """
    return _asked((f"SCHED_FIFO {priority}", lambda: _set_fifo(priority)))


def _asked(*requests: tuple[str, Callable[[], None]]) -> RealTimeReport:
    granted = []
    refused = {}
    for name, ask in requests:
        try:
            ask()
        except OSError as error:
            hint = _WAY_OUT.get(error.errno or 0, {}).get(name.split()[0])
            reason = error.strerror or str(error)
            refused[name] = f"{reason}; {hint}" if hint else reason
        else:
            granted.append(name)
    return RealTimeReport(tuple(granted), refused)


_WAY_OUT = {
    errno.EPERM: {
        "SCHED_FIFO": "raise the user's rtprio limit",
        "memory": "raise the user's memlock limit",
    },
    errno.ENOMEM: {"memory": "raise the user's memlock limit"},
    errno.EINVAL: {"SCHED_FIFO": "the priority must be 1 to 99"},
}


def _set_timer_slack() -> None:
    if _libc.prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(1), 0, 0, 0):
        raise _last_error()


def _set_fifo(priority: int) -> None:
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    os.sched_setscheduler(0, policy, os.sched_param(priority))


def _set_middleware_fifo(priority: int) -> None:
    """Raise the threads that Python has not started: here those of the middleware."""
    ours = {thread.native_id for thread in threading.enumerate()}
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    for task in map(int, os.listdir("/proc/self/task")):
        if task not in ours:
            with contextlib.suppress(ProcessLookupError):  # it has ended meanwhile
                os.sched_setscheduler(task, policy, os.sched_param(priority))


def _lock_memory() -> None:
    """Lock what is mapped now, and what comes later only where no limit could make that fail."""
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    limitless = limit == resource.RLIM_INFINITY or os.geteuid() == 0
    if _libc.mlockall(_MCL_CURRENT | _MCL_FUTURE if limitless else _MCL_CURRENT):
        raise _last_error()


def _freeze_garbage() -> None:
    gc.collect()
    gc.freeze()


def _last_error() -> OSError:
    code = ctypes.get_errno()
    return OSError(code, os.strerror(code))
