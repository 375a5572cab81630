# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A local model of interaction at the rate of the force loop, and its wave port (App. E).

The port decodes a wave u2 into velocity, and encodes the force of the model, at every tick::

    F = F0 + G xd,   xd = sqrt(2/b) u2 - F/b,   v2 = u2 - sqrt(2/b) F
    F = (F0 + sqrt(2/b) G u2)/(1 + G/b),   v2 = (b - G)/(b + G) u2 - sqrt(2/b) F0/(1 + G/b)

The loop through F and xd is solved within the tick, so the port takes exactly F xd.

The spring and damper goes by the implicit midpoint rule: F0 = K x, G = K T_c/2 + B, x+ = x + T_c
xd. Then F xd T_c is what the spring gains plus B xd^2 T_c: passive for every K, B >= 0 and every
tick. It is in place everywhere, or while the *device* is on one side of ``begins_m``: its own
position is that of a high-passed motion, which returns to zero. Where it begins its spring is at
rest; where it ends the energy of the spring is dropped. Meanwhile it pulls as well as it pushes,
since its force comes on top of the one of the server. Where it is not, F = 0 and v2 = u2.

Equations: docs/theory.md 1.6, 8.1, 8.2, 8.3.
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, each, plus, scaled, squared, zero
from pmwvc_core.law.wave.wave import Impedance, free_velocity, wave_v, wave_velocity
from pmwvc_core.params import LocalModelParams

EVERYWHERE, ABOVE, BELOW = 0, 1, 2


class LocalModel(NamedTuple):
    """The spring [m], its force and slope of this tick, whether it is in place, and its heat."""

    x: Vector
    f0: Vector  # [N]
    slope: float  # [N s/m]
    there: bool
    dissipated_j: float


class SpringDamper(NamedTuple):
    """K [N/m], B [N s/m], where it is in place, and the tick."""

    stiffness: float
    damping: float
    acts: int
    begins_m: float
    tick_s: float


def spring_damper(local: LocalModelParams, tick_s: float) -> SpringDamper:
    """Return the parameters of a local model."""
    acts = {"everywhere": EVERYWHERE, "above": ABOVE}.get(local.acts, BELOW)
    return SpringDamper(local.stiffness, local.damping, acts, local.begins_m, tick_s)


def resting_local(axes: int) -> LocalModel:
    """Return a local model at rest."""
    return LocalModel((0.0,) * axes, (0.0,) * axes, 0.0, True, 0.0)


def local_stored_j(s: LocalModel, p: SpringDamper) -> float:
    """Return the energy of the spring, K |x|^2/2 [J]."""
    return squared(s.x) * p.stiffness * 0.5


def changed_local(s: LocalModel, old: SpringDamper) -> LocalModel:
    """Drop the old spring."""
    lost_j = s.dissipated_j + local_stored_j(s, old)
    return LocalModel(zero(s.x), s.f0, s.slope, True, lost_j)


def local_offer(
    s: LocalModel, device_x: Vector, p: SpringDamper, b: Impedance
) -> tuple[LocalModel, Vector, float]:
    """Return v0 [sqrt(W)] and g of the answer v0 + g u2."""
    x, dissipated_j, there = s.x, s.dissipated_j, True
    if p.acts == ABOVE:
        there = device_x[0] > p.begins_m
    elif p.acts == BELOW:
        there = device_x[0] < p.begins_m
    f0, slope = scaled(x, p.stiffness), p.stiffness * (0.5 * p.tick_s) + p.damping
    if not there:
        dissipated_j += local_stored_j(s, p)
        x, f0, slope = zero(x), zero(x), 0.0
    ratio = 1.0 + slope / b.b
    v0 = each(_over, (wave_v(b, zero(f0), f0),), ratio)
    return LocalModel(x, f0, slope, there, dissipated_j), v0, 2.0 / ratio - 1.0


def _over(a: float, b: float) -> float:
    return a / b


def local_answer(
    s: LocalModel, u2: Vector, p: SpringDamper, b: Impedance
) -> tuple[LocalModel, Vector]:
    """Take the wave of the tick; return the one that comes back [sqrt(W)]."""
    loose = plus(s.f0, scaled(free_velocity(b, u2), s.slope))
    f = each(_over, (loose,), 1.0 + s.slope / b.b)
    xd, v2 = wave_velocity(b, u2, f), wave_v(b, u2, f)
    xd = xd if s.there else zero(xd)
    x = plus(s.x, scaled(xd, p.tick_s))
    dissipated_j = s.dissipated_j + squared(xd) * p.damping * p.tick_s
    return LocalModel(x, s.f0, s.slope, s.there, dissipated_j), v2
