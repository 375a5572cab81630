# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The shared object, m_o x'' + b_o x' = sum of the contact forces (App. B, Eq. 1), and a wall.

Two ways to go one step on: exactly under forces held over the step (what sampled couplings use),
and by the midpoint rule (implicit coupling), which keeps the account of kinetic energy to
rounding::

    m_o (v1 - v0)/h + b_o v = F,   v = (v0 + v1)/2,   x1 = x0 + h v

A wall never moves: whatever the force, velocity zero, no energy taken.

Equations: docs/theory.md 4.2.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.motion import Motion, advanced, motion
from pmwvc_core.law.vectors import Vector, dot, minus, plus, scaled, squared, zero


class BodyLaw(NamedTuple):
    """m_o [kg], b_o [N s/m], the time step h [s], and what follows from them."""

    mass: float
    damping: float
    period_s: float
    inertance: float  # 2 m/h [N s/m]; infinite for a wall
    motion: Motion  # over a step
    fixed: bool


class Body(NamedTuple):
    """Position [m] and velocity [m/s]."""

    x: Vector
    xd: Vector


def body_law(mass: float, damping: float, period_s: float) -> BodyLaw:
    """Return the law of a free object."""
    return BodyLaw(
        mass, damping, period_s, 2.0 * mass / period_s, motion(mass, damping, period_s), False
    )


def wall_law(period_s: float) -> BodyLaw:
    """Return the law of a wall."""
    return BodyLaw(math.inf, 0.0, period_s, math.inf, Motion(0.0, 0.0, 0.0, 0.0), True)


def changed_body(s: Body, old: BodyLaw, new: BodyLaw) -> Body:
    """Go on with the velocity at which another mass has the same energy."""
    if new.fixed or new.mass == old.mass:
        return s
    return Body(s.x, scaled(s.xd, math.sqrt(old.mass / new.mass)))


def kinetic_j(s: Body, p: BodyLaw) -> float:
    """Return m_o |xd|^2 / 2 [J]."""
    return 0.0 if p.fixed else 0.5 * p.mass * squared(s.xd)


def pushed_body(s: Body, force: Vector, p: BodyLaw) -> tuple[Body, Vector, float]:
    """Go one step on exactly under a held force [N]; return displacement [m] and the energy
    lost to ground [J], work minus gain in motion.
    """
    if p.fixed:
        return s, zero(force), 0.0
    moved, xd = advanced(zero(s.x), s.xd, force, p.motion)
    after = Body(plus(s.x, moved), xd)
    return after, moved, dot(force, moved) - (kinetic_j(after, p) - kinetic_j(s, p))


def imbalance(xd: float, velocity: float, force: float, p: BodyLaw) -> float:
    """Return the force missing along an axis, (2 m/h + b_o) v - 2 m/h v0 - force [N]; a wall bears
    any force.
    """
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
