# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock of a loop: absolute deadlines ``k * period + phase`` of the monotonic clock, so that
lateness does not add up and loops of a machine keep their phases; counts of how they were met; and
the system's help in meeting them: real-time priority, locked memory, exact timers.
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
from dataclasses import dataclass

_PR_SET_TIMERSLACK, _ONE_NS = 29, (ctypes.c_ulong(1), 0, 0, 0)
_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_FIFO = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
_libc = ctypes.CDLL(None, use_errno=True)


def sleep_until(deadline_ns: int) -> None:
    """Sleep until the monotonic clock shows a time, whatever signals come meanwhile."""
    time.sleep(max(deadline_ns - time.monotonic_ns(), 0) * 1e-9)


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
        self,
        period_ns: int,
        *,
        phase_ns: int = 0,
        recover_ns: int = 25_000_000,
        clock: Callable[[], int] = time.monotonic_ns,
        sleep: Callable[[int], None] = sleep_until,
    ) -> None:
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


Granted = dict[str, str]  # real-time requests: why the system refused each, "" where granted


def granted_words(report: Granted) -> str:
    """Return what was granted and refused in one line."""
    words = (f"{name} {f'refused ({why})' if why else 'granted'}" for name, why in report.items())
    return "; ".join(words) or "not requested yet"


def hold_memory() -> Granted:
    """Ask for memory that stays where it is, after set-up: locked, the garbage collector's
    survivors frozen. It takes up to seconds: before a node can be started, so that nodes begin
    together.
    """

    def freeze() -> None:
        gc.collect()
        gc.freeze()

    return _asked(("memory lock", _lock_memory), ("frozen garbage collector", freeze))


def request_real_time(priority: int) -> Granted:
    """Ask, from the loop's own thread, for what makes it wake in time: timer slack, SCHED_FIFO
    (priority 1 to 99), and the middleware's threads one step below. A refusal is reported.
    """
    return _asked(
        ("timer slack 1 ns", lambda: _checked(_libc.prctl(_PR_SET_TIMERSLACK, *_ONE_NS))),
        (f"SCHED_FIFO {priority}", lambda: _set_fifo(priority)),
        ("SCHED_FIFO of the middleware", lambda: _set_middleware_fifo(max(priority - 1, 1))),
    )


def request_reception(priority: int) -> Granted:
    """Ask for reception whatever else the machine does; a loop of its own may be late."""
    return _asked(("SCHED_FIFO of the middleware", lambda: _set_middleware_fifo(priority)))


def request_priority(priority: int) -> Granted:
    """Ask for SCHED_FIFO for the calling thread, which sleeps most of the time."""
    return _asked((f"SCHED_FIFO {priority}", lambda: _set_fifo(priority)))


def _asked(*requests: tuple[str, Callable[[], None]]) -> Granted:
    found = {}
    for name, ask in requests:
        try:
            ask()
            found[name] = ""
        except OSError as error:
            hint = _WAY_OUT.get((error.errno or 0, name.split()[0]))
            reason = error.strerror or str(error)
            found[name] = f"{reason}; {hint}" if hint else reason
    return found


_MEMLOCK = "raise the user's memlock limit"
_WAY_OUT = {
    (errno.EPERM, "SCHED_FIFO"): "raise the user's rtprio limit",
    (errno.EINVAL, "SCHED_FIFO"): "the priority must be 1 to 99",
    **{(errno.EPERM, "memory"): _MEMLOCK, (errno.ENOMEM, "memory"): _MEMLOCK},
}


def _set_fifo(priority: int) -> None:
    os.sched_setscheduler(0, _FIFO, os.sched_param(priority))


def _set_middleware_fifo(priority: int) -> None:
    """Raise the threads that Python has not started: here those of the middleware."""
    ours = {thread.native_id for thread in threading.enumerate()}
    for task in map(int, os.listdir("/proc/self/task")):
        if task not in ours:
            with contextlib.suppress(ProcessLookupError):  # it has ended meanwhile
                os.sched_setscheduler(task, _FIFO, os.sched_param(priority))


def _lock_memory() -> None:
    """Lock what is in use, and what comes later only where no limit could make that fail."""
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    limitless = limit == resource.RLIM_INFINITY or os.geteuid() == 0
    which = _MCL_CURRENT | _MCL_FUTURE if limitless else _MCL_CURRENT
    _checked(_libc.mlockall(which | _MCL_ONFAULT))


def _checked(failed: int) -> None:
    if failed:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


class Paced:
    """What every loop notes for its diagnostics: lateness and computing time of each tick since
    somebody looked, who puts another list there (``took_ns``, one after the other), deadlines
    ``missed``, and what the system granted, before the start (``memory``) and then.
    """

    def __init__(self) -> None:
        self.took_ns, self.missed = list[int](), 0
        self.memory, self.report = Granted(), Granted()

    def request(self, priority: int) -> None:
        """Ask for real time, from the loop's own thread."""
        self.report = self.memory | request_real_time(priority)
