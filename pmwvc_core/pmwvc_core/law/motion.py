# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Motion of a damped mass: exact under a constant force; and the shared object, or a wall.

m x'' + b x' = F over a time t, with z = b t / m, and the limits 1 and 1/2 for z -> 0::

    xd(t) = e^-z xd + (t/m) phi1(z) F               phi1(z) = (1 - e^-z)/z
    x(t)  = x + t phi1(z) xd + (t^2/m) phi2(z) F    phi2(z) = (z - 1 + e^-z)/z^2

The object, m_o x'' + b_o x' = sum of the contact forces (App. B, Eq. 1), goes one step on exactly
under held forces (sampled couplings), or by the midpoint rule (implicit coupling)::

    m_o (v1 - v0)/h + b_o v = F,   v = (v0 + v1)/2,   x1 = x0 + h v

A wall never moves, and takes no energy. Equations: docs/theory.md 1.7, 4.2.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, dot, minus, plus, scaled, squared, zero

SERIES_BELOW = 0.1  # phi2 by its series there: the closed form loses digits to cancellation


class StepMap(NamedTuple):
    """Coefficients of the map from (x, xd, F) to (x, xd) after a given time."""

    xd_x: float  # [s] of the velocity in the new position
    f_x: float  # [m/N]
    xd_xd: float  # [-]
    f_xd: float  # [m/s/N]


def motion(mass: float, damping: float, time_s: float) -> StepMap:
    """Return the exact motion of a mass [kg] with a damper [N s/m] over a time."""
    z, rate = damping * time_s / mass, time_s / mass
    phi1, phi2, term = -math.expm1(-z) / z if z else 1.0, 0.0, 0.5
    if z >= SERIES_BELOW:
        phi2 = (z + math.expm1(-z)) / (z * z)
    else:
        for n in range(10):
            phi2 += term
            term *= -z / (n + 3)
    return StepMap(time_s * phi1, time_s * rate * phi2, math.exp(-z), rate * phi1)


def advanced(x: Vector, xd: Vector, force: Vector, p: StepMap) -> tuple[Vector, Vector]:
    """Return position [m] and velocity [m/s] after the time; the force [N] is constant."""
    x = plus(plus(x, scaled(xd, p.xd_x)), scaled(force, p.f_x))
    return x, plus(scaled(xd, p.xd_xd), scaled(force, p.f_xd))


def time_to_rest(mass: float, damping: float, speed: float, force: float) -> float:
    """Return when a constant force against the velocity has stopped the mass, xd(t) = 0 [s]: t =
    -(m xd/F) ln(1 + r)/r with r = -b xd/F.
    """
    undamped = -mass * speed / force
    r = undamped * damping / mass
    return undamped * math.log1p(r) / r if r > 0.0 else undamped


class BodyLaw(NamedTuple):
    """m_o [kg], b_o [N s/m], the time step h [s], and what follows from them."""

    mass: float
    damping: float
    period_s: float
    inertance: float  # 2 m/h [N s/m]; infinite for a wall
    motion: StepMap  # over a step
    fixed: bool


class Body(NamedTuple):
    """Position [m] and velocity [m/s]."""

    x: Vector
    xd: Vector


def body_law(mass: float, damping: float, period_s: float) -> BodyLaw:
    """Return the law of a free object, or of a wall: an infinite mass."""
    of_step, fixed = motion(mass, damping, period_s), math.isinf(mass)
    return BodyLaw(mass, damping, period_s, 2.0 * mass / period_s, of_step, fixed)


def changed_body(s: Body, old: BodyLaw, new: BodyLaw) -> Body:
    """Go on with the velocity at which another mass has the same energy."""
    if new.fixed or new.mass == old.mass:
        return s
    return Body(s.x, scaled(s.xd, math.sqrt(old.mass / new.mass)))


def kinetic_j(s: Body, p: BodyLaw) -> float:
    """Return m_o |xd|^2 / 2 [J]."""
    return 0.0 if p.fixed else 0.5 * p.mass * squared(s.xd)


def pushed_body(s: Body, force: Vector, p: BodyLaw) -> tuple[Body, Vector, float]:
    """Go one step on exactly under a held force [N]; return the way [m] and what is lost [J]."""
    if p.fixed:
        return s, zero(force), 0.0
    moved, xd = advanced(zero(s.x), s.xd, force, p.motion)
    after = Body(plus(s.x, moved), xd)
    return after, moved, dot(force, moved) - (kinetic_j(after, p) - kinetic_j(s, p))


def imbalance(xd: float, velocity: float, force: float, p: BodyLaw) -> float:
    """Return the force missing along an axis [N], (2 m/h + b_o) v - 2 m/h v0 - force."""
    return 0.0 if p.fixed else p.inertance * (velocity - xd) + p.damping * velocity - force


def mobility(slope: float, p: BodyLaw) -> float:
    """Return 1/(2 m/h + b_o + slope) [m/s/N]; contacts add their slope [N s/m]."""
    return 0.0 if p.fixed else 1.0 / (p.inertance + p.damping + slope)


def drifted(s: Body, velocity: Vector, p: BodyLaw) -> tuple[Body, float]:
    """Go one step on at a mean velocity [m/s]; return h b_o |v|^2, lost to ground [J]."""
    if p.fixed:
        return s, 0.0
    after = Body(plus(s.x, scaled(velocity, p.period_s)), minus(scaled(velocity, 2.0), s.xd))
    return after, p.period_s * p.damping * squared(velocity)
