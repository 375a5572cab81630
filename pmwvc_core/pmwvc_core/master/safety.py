# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the safety limits report, and which of their changes are allowed while a hand is on the
device. The limits themselves are in :mod:`pmwvc_core.law.safety.limits`.

A limit may only be lowered, ``soft_start_s`` and ``max_torque`` stay: anybody on the network can
set a parameter. To widen one the master is started anew, without a force. How fast the force may
change must still let the largest force go in ``LET_GO_S``.
"""

import enum

from pmwvc_core.errors import ParameterError
from pmwvc_core.law.safety import limits as causes
from pmwvc_core.law.safety.limits import LET_GO_S
from pmwvc_core.params import SafetyParams, specs

BRAKING = "waves late: braking"  # coupled, with the brake's force beside the controller's
UNCOUPLED = "clutch: the hand moves alone"  # coupled, and the hand has left its avatar
LOWERED = ("max_force", "max_slew", "damper_velocity", "fault_velocity", "timeout_s", "release_s")


class SafetyState(enum.IntEnum):
    """The numbers are those of the MasterTrace message."""

    STARTING = 0
    COUPLED = 1
    DAMPING = 2
    FAULT = 3


STARTING, COUPLED, DAMPING, FAULT = SafetyState
# By cause: the state that it means, and the cause in words.
_MEANT: dict[int, tuple[SafetyState, str]] = {
    causes.NONE: (COUPLED, ""),
    causes.WAITING: (STARTING, "waiting for the server's first answer or a working device"),
    causes.SOFT_START: (STARTING, "soft start"),
    causes.SILENT: (DAMPING, "server silent: damping only"),
    causes.RELEASED: (DAMPING, "server silent: damping released"),
    causes.TOO_FAST: (DAMPING, "faster than {0.damper_velocity:g} m/s: damping only"),
    causes.NOT_FINITE: (DAMPING, "a value is not a finite number: no force"),
    causes.RUNAWAY: (FAULT, "faster than {0.fault_velocity:g} m/s: no force until re-armed"),
    causes.OUTSIDE: (DAMPING, "beyond the device's workspace: damping only"),
    causes.DEVICE_SILENT: (DAMPING, "device silent: no force"),
    causes.DEVICE_LOST: (FAULT, "device silent for more than 1 s: no force until re-armed"),
    causes.UNRECEIVED: (DAMPING, "server receives nothing from this user: damping only"),
    causes.LATE: (COUPLED, BRAKING),
}


def state_of(cause: int) -> SafetyState:
    """Return the state that a cause means."""
    return _MEANT[cause][0]


def text_of(cause: int, limits: SafetyParams) -> str:
    """Return a cause in words, empty when all is well."""
    return _MEANT[cause][1].format(limits)


def check_change(now: SafetyParams, wanted: SafetyParams) -> None:
    """Refuse a change that makes any limit wider: ParameterError naming each with its value."""
    problems = [
        f"safety.{name} = {getattr(wanted, name):g}: can only be lowered while running (now "
        f"{getattr(now, name):g} {specs(SafetyParams)[name].unit}); restart the master with "
        "another value"
        for name in LOWERED
        if getattr(wanted, name) > getattr(now, name)
    ]
    slowest = wanted.max_force / LET_GO_S
    if wanted.max_slew < min(slowest, now.max_slew):
        problems.append(
            f"safety.max_slew = {wanted.max_slew:g}: must be >= {slowest:g} N/s, so that "
            f"safety.max_force = {wanted.max_force:g} N can fall to zero in {LET_GO_S:g} s"
        )
    if problems:
        raise ParameterError("; ".join(problems))
