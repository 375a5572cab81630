# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Exact motion of a damped mass under a constant force.

m x'' + b x' = F over a time t, with z = b t / m::

    xd(t) = e^-z xd + (t/m) phi1(z) F
    x(t)  = x + t phi1(z) xd + (t^2/m) phi2(z) F
    phi1(z) = (1 - e^-z)/z,  phi2(z) = (z - 1 + e^-z)/z^2

with the limits 1 and 1/2 for z -> 0.

Equations: docs/theory.md 1.7.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, columns, each

SERIES_BELOW = 0.1  # phi2 by its series there: the closed form loses digits to cancellation
TERMS = 10


class Motion(NamedTuple):
    """Coefficients of the map from (x, xd, F) to (x, xd) after a given time."""

    xd_x: float  # [s] of the velocity in the new position
    f_x: float  # [m/N]
    xd_xd: float  # [-]
    f_xd: float  # [m/s/N]


def motion(mass: float, damping: float, time_s: float) -> Motion:
    """Return the exact motion of a mass [kg] with a damper [N s/m] over a time."""
    z, rate = damping * time_s / mass, time_s / mass
    phi1, phi2, term = -math.expm1(-z) / z if z else 1.0, 0.0, 0.5
    if z >= SERIES_BELOW:
        phi2 = (z + math.expm1(-z)) / (z * z)
    else:
        for n in range(TERMS):
            phi2 += term
            term *= -z / (n + 3)
    return Motion(time_s * phi1, time_s * rate * phi2, math.exp(-z), rate * phi1)


def advanced(x: Vector, xd: Vector, force: Vector, p: Motion) -> tuple[Vector, Vector]:
    """Return position [m] and velocity [m/s] after the time; the force [N] is constant."""
    moved: tuple[Vector, Vector] = columns(each(_advanced, (x, xd, force), p))
    return moved


def _advanced(x: float, xd: float, force: float, p: Motion) -> tuple[float, float]:
    return x + p.xd_x * xd + p.f_x * force, p.xd_xd * xd + p.f_xd * force


def time_to_rest(mass: float, damping: float, speed: float, force: float) -> float:
    """Return when a constant force has stopped the mass [s].

    From xd(t) = 0: t = -(m xd/F) ln(1 + r)/r with r = -b xd/F. The force opposes the velocity;
    where it does not, the result has no meaning.
    """
    undamped = -mass * speed / force
    r = undamped * damping / mass
    return undamped * math.log1p(r) / r if r > 0.0 else undamped
