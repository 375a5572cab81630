# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The properties of a user's line that decide which motions without a force it leaves free.

Where a run of a batch has its own, it is a row per run, ``(runs, 1)``.
"""

from typing import Any

import numpy as np

from pmwvc_analysis.models.links import Line
from pmwvc_core.numeric import Array, Flags, Value, root
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance


def stiffness(line: Line) -> Array:
    """Return the stiffness of the contact [N/m]."""
    return per_run(line.user.contact.contact_stiffness)


def tied(line: Line) -> Flags:
    """Tell where a position feedback ties the device to its avatar."""
    position = line.user.master.position
    is_on = line.waves and position.is_on
    return np.asarray(per_run(position.gain if is_on else 0.0) > 0.0)


def alone(line: Line) -> Flags:
    """Tell where the contact exerts nothing."""
    damping = per_run(line.user.contact.contact_damping)
    return np.asarray((stiffness(line) == 0.0) & (damping == 0.0))


def braked(line: Line) -> Flags:
    """Tell where the device is damped."""
    return np.asarray(per_run(line.user.device.damping) > 0.0)


def steady_age(line: Line) -> bool:
    """Tell whether motion is reported equally late at every step: else the contact is stretched in
    turns, and there is no uniform motion without forces. Waves do not mind.
    """
    return line.waves or len(set(line.up.ages())) == 1


def steady_answers(line: Line) -> bool:
    """Tell whether a position feedback gets the avatar's position equally late at every tick."""
    return line.answer.period == 1 and line.serve.period == 1


def received_at(line: Line, tick: int) -> int:
    """Return when the answer was sent that the master has at a tick."""
    return line.serve.last(line.answer.last(tick) - line.delay_down)


def moves_device(line: Line, xd: Array) -> Array:
    """Return the velocity of the device while the avatar moves with xd, both without a force;
    without waves both are the same.
    """
    return _passed(xd, line.user.server_impedance, line.user.impedance) if line.waves else xd


def moves_avatar(line: Line, xd: Array) -> Array:
    """Return the velocity of the avatar while the device moves with xd, likewise."""
    return _passed(xd, line.user.impedance, line.user.server_impedance) if line.waves else xd


def _passed(xd: Array, sent: Impedance, received: Impedance) -> Array:
    """Return the velocity that a wave of a velocity makes at a port of another impedance."""
    ends: list[Any] = [
        b if isinstance(b, MatrixImpedance) else per_run(b) for b in (sent, received)
    ]
    return np.asarray(root(ends[0]) * xd / root(ends[1]))


def per_run(value: Value) -> Array:
    """Return a number, or one per run, as a row per run."""
    return np.asarray(value, dtype=float).reshape(-1, 1)
