# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reports of the safety limits: state, cause, and the text of either.

The limits themselves are in :mod:`pmwvc_core.law.safety.limits`.
"""

import enum

from pmwvc_core.params import SafetyParams

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


def state_of(cause: int) -> SafetyState:
    """Return the state that a cause means."""
    return _STATES[Cause(cause)]


def text_of(cause: int, limits: SafetyParams) -> str:
    """Return a cause in words, empty when all is well."""
    if cause == Cause.TOO_FAST:
        return f"faster than {limits.damper_velocity:g} m/s: damping only"
    if cause == Cause.RUNAWAY:
        return f"faster than {limits.fault_velocity:g} m/s: no force until re-armed"
    return _TEXTS[Cause(cause)]
