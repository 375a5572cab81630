# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The largest force of a brake that holds on while no waves come.

It is ``RATIO`` times the mean force over ``MEAN_S`` before the wait. It grows over ``RISE_S``,
stays while the end waits, and fades over ``return_s`` once waves are back; a wait meanwhile takes
it up from there.

Equations: docs/theory.md 17.15.
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, each, length, zero

RATIO = 1.3
MEAN_S = 0.05
RISE_S = 0.04


class BrakeForce(NamedTuple):
    """Mean force rendered [N], the largest one in a wait [N], and what ratio of that acts."""

    mean: Vector
    held: float
    left: float


def resting_brake(like: Vector) -> BrakeForce:
    """Return the brake of an end that renders no force."""
    return BrakeForce(zero(like), 0.0, 0.0)


def brake_limit(s: BrakeForce) -> float:
    """Return the largest force of the present step [N]; zero where nothing is held."""
    return s.held * s.left


def brake_force(s: BrakeForce, waits: bool, f: Vector, h: float, return_s: float) -> BrakeForce:
    """Go one step of h [s] on: whether no waves come, at this end or at the other one, and the
    force rendered in the last step [N].
    """
    mean, held = s.mean, s.held
    if s.left <= 0.0:
        mean = each(_smoothed, (mean, f), min(h / MEAN_S, 1.0))
        if not waits:
            return BrakeForce(mean, held, 0.0)
        held = RATIO * length(mean)
    change = h / RISE_S if waits else -h / return_s
    return BrakeForce(mean, held, min(max(s.left + change, 0.0), 1.0))


def _smoothed(mean: float, f: float, weight: float) -> float:
    return mean + weight * (f - mean)
