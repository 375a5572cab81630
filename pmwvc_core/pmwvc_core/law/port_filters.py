# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The filters between a device and its wave port, and the loop through them.

A filter lets through w of the returning wave v, and answers the outgoing wave u_m within the tick,
with v0 + g u_m, |g| < 1, so that

    v_m = w + v0 + g u_m,   u_m = (sqrt(2b) xd - w - v0)/(1 + g)

One that filters the velocity of the force alone has no part in the waves. Order within a tick:
``answered``, ``force_velocity``, then ``wave_shortened`` where the limits let another force
through, and ``filters_up``. Members are chosen by their state; :class:`NoFilter` is the port
without any.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.family import Family
from pmwvc_core.law.vectors import Vector, scaled, squared

# (s, v, x, xd, p, impedance) -> (s, v_m): the wave at the port, with the answer to its own u_m
answered = Family("answered")
force_velocity = Family("force_velocity")  # (s, xd, p, impedance) -> (s, velocity for the force)
# (s, u_m, v_m, missing) -> (u_m, v_m, deficit): the longest wave that is paid for with so much
# more than twice its own power [W], and what is not paid for then
wave_shortened = Family("wave_shortened")
filters_up = Family("filters_up")  # (s, u, p) -> (s, what of the outgoing wave goes on)


class NoFilter(NamedTuple):
    """Nothing between device and port."""

    none: int


@answered.member(NoFilter)
def _answered(
    s: NoFilter, v: Vector, x: Vector, xd: Vector, p: NoFilter, impedance: NamedTuple
) -> tuple[NoFilter, Vector]:
    return s, v


@force_velocity.member(NoFilter)
def _force_velocity(
    s: NoFilter, xd: Vector, p: NoFilter, impedance: NamedTuple
) -> tuple[NoFilter, Vector]:
    return s, xd


@wave_shortened.member(NoFilter)
def _wave_shortened(
    s: NoFilter, u_m: Vector, v_m: Vector, missing: float
) -> tuple[Vector, Vector, float]:
    """Shorten u_m to |u|^2 <= |u_m|^2 + missing."""
    natural = squared(u_m)
    budget = natural + missing
    if budget >= natural:
        return u_m, v_m, 0.0
    spent = max(budget, 0.0)
    ratio = math.sqrt(spent / natural) if natural > 0.0 else 1.0
    return scaled(u_m, min(ratio, 1.0)), v_m, max(spent - budget, 0.0)


@filters_up.member(NoFilter)
def _up(s: NoFilter, u: Vector, p: NoFilter) -> tuple[NoFilter, Vector]:
    return s, u
