# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A force that jumps while hardly anything moved: a fault of the environment.

With s the longest way in this step of any avatar or of the object (fading over ``MEMORY_S``), a
change of force since the last one that was used, n steps ago, is accepted up to

    |F - F-| <= 100 (b/T) s + b n ``KICK_M_S``

The first term is the stiffest contact that the port can learn (``secant.LARGEST``); by the second
a force that stays is accepted soon.

Equations: docs/theory.md 5.13.
"""

from typing import NamedTuple

from pmwvc_core.law.black_box.secant import LARGEST
from pmwvc_core.law.vectors import Vector, length, minus, zero

KICK_M_S = 0.4  # change of force over b
MEMORY_S = 0.5


class Jumps(NamedTuple):
    """Position, the last force that was used, and the steps since."""

    position: Vector
    force: Vector
    steps: int


def resting_jumps(position: Vector) -> Jumps:
    """Begin without force."""
    return Jumps(position, zero(position), 0)


def faded(way_m: float, period_s: float) -> float:
    """Return what is left of the longest way after a step [m]."""
    return max(1.0 - period_s / MEMORY_S, 0.0) * way_m


def explained(
    s: Jumps, position: Vector, force: Vector, good: bool, way_m: float, scale: float,
    period_s: float,
) -> tuple[Jumps, bool]:  # fmt: skip
    """Tell whether a force [N] at an avatar [m] can be used; ``scale`` is b/T [N/m]."""
    steps = s.steps + 1
    most = LARGEST * scale * way_m + KICK_M_S * scale * period_s * steps
    found = length(minus(force, s.force)) <= most
    if good and found:
        return Jumps(position, force, 0), found
    return Jumps(position, s.force, steps), found
