# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reports of the safety limits: state, cause, and the text of either.

The limits themselves are in :mod:`pmwvc_core.master.safety.limiter`.
"""

import enum
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Flag, Value, where
from pmwvc_core.params import SafetyParams
from pmwvc_core.state import Stateful

Integers: TypeAlias = NDArray[np.int64]


BRAKING = "waves late: braking"  # coupled, with the brake's force beside the controller's


class SafetyState(enum.IntEnum):
    """The numbers are those of the MasterTrace message."""

    STARTING = 0
    COUPLED = 1
    DAMPING = 2
    FAULT = 3


class Cause(enum.IntEnum):
    """The cause of a state."""

    NONE = 0
    WAITING = 1
    SOFT_START = 2
    SILENT = 3
    RELEASED = 4
    TOO_FAST = 5
    NOT_FINITE = 6
    RUNAWAY = 7
    OUTSIDE = 8
    DEVICE_SILENT = 9
    DEVICE_LOST = 10
    UNRECEIVED = 11
    LATE = 12


_STATES = {
    Cause.NONE: SafetyState.COUPLED,
    Cause.WAITING: SafetyState.STARTING,
    Cause.SOFT_START: SafetyState.STARTING,
    Cause.SILENT: SafetyState.DAMPING,
    Cause.RELEASED: SafetyState.DAMPING,
    Cause.TOO_FAST: SafetyState.DAMPING,
    Cause.NOT_FINITE: SafetyState.DAMPING,
    Cause.RUNAWAY: SafetyState.FAULT,
    Cause.OUTSIDE: SafetyState.DAMPING,
    Cause.DEVICE_SILENT: SafetyState.DAMPING,
    Cause.DEVICE_LOST: SafetyState.FAULT,
    Cause.UNRECEIVED: SafetyState.DAMPING,
    Cause.LATE: SafetyState.COUPLED,
}
_STATE_OF = np.array([_STATES[cause] for cause in Cause])
_TEXTS: dict[int, str] = {
    Cause.NONE: "",
    Cause.WAITING: "waiting for the server's first answer or a working device",
    Cause.SOFT_START: "soft start",
    Cause.SILENT: "server silent: damping only",
    Cause.RELEASED: "server silent: damping released",
    Cause.UNRECEIVED: "server receives nothing from this user: damping only",
    Cause.LATE: BRAKING,
    Cause.OUTSIDE: "beyond the device's workspace: damping only",
    Cause.DEVICE_SILENT: "device silent: no force",
    Cause.DEVICE_LOST: "device silent for more than 1 s: no force",
    Cause.NOT_FINITE: "a value is not a finite number: no force",
}


class Seen(NamedTuple):
    """Conditions found at the last tick; flags per run."""

    active: Flag = False
    good: Flag = True
    faulty: Flag = False
    silent: Flag = False
    released: Flag = False
    fast: Flag = False
    outside: Flag = False
    gone: Flag = False
    lost: Flag = False
    unreceived: Flag = False
    late: Flag = False


def cause_of(seen: Seen, gain: Value) -> int | Integers:
    """Return the weightiest cause, given the ratio of the force that is let through."""
    cause: Any = where(seen.late, Cause.LATE, Cause.NONE)
    cause = where(gain < 1.0, Cause.SOFT_START, cause)
    cause = where(seen.unreceived, Cause.UNRECEIVED, cause)
    cause = where(seen.fast, Cause.TOO_FAST, cause)
    cause = where(seen.outside, Cause.OUTSIDE, cause)
    cause = where(seen.silent, Cause.SILENT, cause)
    cause = where(seen.released, Cause.RELEASED, cause)
    cause = where(seen.good, cause, Cause.NOT_FINITE)
    cause = where(seen.active, cause, Cause.WAITING)
    cause = where(seen.gone, Cause.DEVICE_SILENT, cause)
    cause = where(seen.lost, Cause.DEVICE_LOST, cause)
    return _whole(where(seen.faulty, Cause.RUNAWAY, cause))


def state_of(cause: int | Integers) -> int | Integers:
    """Return the state that a cause means."""
    if isinstance(cause, np.ndarray):
        return np.asarray(_STATE_OF[cause])
    return _STATES[Cause(cause)]


def text_of(cause: int | Integers, limits: SafetyParams) -> str | list[str]:
    """Return a cause in words, empty when all is well; those of all runs where it is an array."""
    if not isinstance(cause, np.ndarray):
        return _text(cause, limits)
    if not cause.any():
        return [""] * cause.size
    return [_text(each, limits, run) for run, each in enumerate(cause.ravel().tolist())]


def _text(cause: int, limits: SafetyParams, run: int = 0) -> str:
    if cause == Cause.TOO_FAST:
        return f"faster than {_number(limits.damper_velocity, run)} m/s: damping only"
    if cause == Cause.RUNAWAY:
        return f"faster than {_number(limits.fault_velocity, run)} m/s: no force until re-armed"
    return _TEXTS[cause]


class Interventions(Stateful):
    """How often the limits intervened.

    Counted are the beginnings of damping, of a fault, of values that are not finite, and of every
    stretch of ticks in which a coupled controller's force or its change was too large.
    """

    MEMORY = "_events _disturbed _limited"

    def __init__(self) -> None:
        self._events: Any = 0  # an int, or integers per run
        self._disturbed: Flag = False
        self._limited: Flag = False

    def step(self, disturbed: Flag, limited: Flag) -> None:
        """Count what begins with this tick: a disturbance, or a force that is limited."""
        begins = disturbed & (self._disturbed ^ True)
        self._events = self._events + begins + (limited & (self._limited ^ True))
        self._disturbed, self._limited = disturbed, limited

    @property
    def count(self) -> int | Integers:
        """An int for a single run, and for a batch an array of integers ``(runs, 1)``."""
        return _whole(self._events)


def _whole(value: Any) -> int | Integers:
    if not isinstance(value, np.ndarray):
        return int(value)
    return value.astype(np.int64) if value.ndim > 1 else int(value.item())


def _number(limit: Value, run: int) -> str:
    values = np.ravel(limit)
    return f"{values[run if len(values) > 1 else 0]:g}"
