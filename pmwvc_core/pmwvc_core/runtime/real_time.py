# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The system's help in meeting deadlines: real-time priority, locked memory, exact timers."""

import contextlib
import ctypes
import errno
import gc
import os
import resource
import threading
from collections.abc import Callable
from dataclasses import dataclass, field

_PR_SET_TIMERSLACK, _ONE_NS = 29, (ctypes.c_ulong(1), 0, 0, 0)
_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_FIFO = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
_libc = ctypes.CDLL(None, use_errno=True)


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
    """Ask for memory that stays where it is, after set-up: locked, the garbage collector's
    survivors frozen. It takes up to seconds: before a node can be started, so that nodes begin
    together.
    """

    def freeze() -> None:
        gc.collect()
        gc.freeze()

    return _asked(("memory lock", _lock_memory), ("frozen garbage collector", freeze))


def request_real_time(priority: int) -> RealTimeReport:
    """Ask, from the loop's own thread, for what makes it wake in time: timer slack, SCHED_FIFO
    (priority 1 to 99), and the middleware's threads one step below. A refusal is reported.
    """
    return _asked(
        ("timer slack 1 ns", lambda: _checked(_libc.prctl(_PR_SET_TIMERSLACK, *_ONE_NS))),
        (f"SCHED_FIFO {priority}", lambda: _set_fifo(priority)),
        ("SCHED_FIFO of the middleware", lambda: _set_middleware_fifo(max(priority - 1, 1))),
    )


def request_reception(priority: int) -> RealTimeReport:
    """Ask for reception whatever else the machine does; a loop of its own may be late."""
    return _asked(("SCHED_FIFO of the middleware", lambda: _set_middleware_fifo(priority)))


def request_priority(priority: int) -> RealTimeReport:
    """Ask for SCHED_FIFO for the calling thread, which sleeps most of the time."""
    return _asked((f"SCHED_FIFO {priority}", lambda: _set_fifo(priority)))


def _asked(*requests: tuple[str, Callable[[], None]]) -> RealTimeReport:
    granted, refused = [], {}
    for name, ask in requests:
        try:
            ask()
        except OSError as error:
            hint = _WAY_OUT.get((error.errno or 0, name.split()[0]))
            reason = error.strerror or str(error)
            refused[name] = f"{reason}; {hint}" if hint else reason
        else:
            granted.append(name)
    return RealTimeReport(tuple(granted), refused)


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
