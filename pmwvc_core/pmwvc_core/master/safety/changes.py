# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The changes of the safety limits that are allowed while a hand is on the device.

A limit may only be lowered, and ``soft_start_s`` stays: anybody on the network can set a
parameter. To widen one the master is started anew, without a force. How fast the force may change
must still let the largest force go in ``LET_GO_S``.
"""

from pmwvc_core.errors import ParameterError
from pmwvc_core.law.safety.limits import LET_GO_S
from pmwvc_core.params import SafetyParams, specs

LOWERED = ("max_force", "max_slew", "damper_velocity", "fault_velocity", "timeout_s", "release_s")


def check_change(now: SafetyParams, wanted: SafetyParams) -> None:
    """Refuse a change that makes any limit wider.

    Raises
    ------
    ParameterError
        Naming each with the value it has now.
    """
    problems = []
    for name in LOWERED:
        value, new = getattr(now, name), getattr(wanted, name)
        if new > value:
            unit = specs(SafetyParams)[name].unit
            problems.append(
                f"safety.{name} = {new:g}: can only be lowered while running "
                f"(now {value:g} {unit}); restart the master with another value"
            )
    slowest = wanted.max_force / LET_GO_S
    if wanted.max_slew < min(slowest, now.max_slew):
        problems.append(
            f"safety.max_slew = {wanted.max_slew:g}: must be >= {slowest:g} N/s, so that "
            f"safety.max_force = {wanted.max_force:g} N can fall to zero in {LET_GO_S:g} s"
        )
    if problems:
        raise ParameterError("; ".join(problems))
