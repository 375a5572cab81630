# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Filter bank with a local model of interaction on the high-pass part of the outgoing wave, at
the rate of the force loop (App. E, Fig. 3).

::

    u_m --> low_up ---> anti-aliasing filter, packets --> server
        '-> high_up --> u2 --> local model --> v2 --> high_down -,
    v_m <---------------- w <-- low_down <-- hold <-- server --(+)

``dissertation``: low_up and low_down are wires, high_up is HP, high_down is LP2; not passive with
the filters of Table 1. ``complementary``: one first-order pair splits and recombines, |H1|^2 +
|H2|^2 = 1: passive for any passive server and local model.

The local model answers within the tick: v_m = w + v0 + g u_m with g = HD (b - G)/(b + G) HU. Its
port decodes u2 and encodes the force of the model::

    F = F0 + G xd,   xd = sqrt(2/b) u2 - F/b,   v2 = u2 - sqrt(2/b) F
    F = (F0 + sqrt(2/b) G u2)/(1 + G/b),   v2 = (b - G)/(b + G) u2 - sqrt(2/b) F0/(1 + G/b)

Spring and damper by the implicit midpoint rule: F0 = K x, G = K T_c/2 + B, x+ = x + T_c xd, so
that F xd T_c is the gain of the spring plus B xd^2 T_c. The model acts everywhere, or while the
device is on one side of ``begins_m``; where it ends, the energy of the spring is dropped.
Equations: docs/theory.md 1.6, 8.1, 8.2, 8.3, 8.4.
"""

from operator import mul
from typing import Any, NamedTuple

from pmwvc_core.law.family import accounts
from pmwvc_core.law.port import port_filters
from pmwvc_core.law.vectors import Vector, columns, each, plus, scaled, squared, zero
from pmwvc_core.law.wave.filter_and_hold import Cascade, Sections, cascade, gain_of, rest_of
from pmwvc_core.law.wave.wave import along, free_velocity, wave_j, wave_v, wave_velocity

ACTS = ("everywhere", "above", "below")  # where a local model is in place
EVERYWHERE, ABOVE, BELOW = range(3)


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


def local_offer(
    s: LocalModel, device_x: Vector, p: SpringDamper, b: Any
) -> tuple[LocalModel, Vector, Vector]:
    """Return v0 [sqrt(W)] and g of the answer v0 + g u2, for each eigenvalue of b."""
    beyond_m, dissipated_j = device_x[0] - p.begins_m, s.dissipated_j
    if p.acts == EVERYWHERE or (beyond_m > 0.0 if p.acts == ABOVE else beyond_m < 0.0):
        slope = p.stiffness * (0.5 * p.tick_s) + p.damping
        s = LocalModel(s.x, scaled(s.x, p.stiffness), slope, True, dissipated_j)
    else:
        dissipated_j += local_stored_j(s, p)
        s = LocalModel(zero(s.x), zero(s.x), 0.0, False, dissipated_j)
    shares = each(_share, (b.values,), s.slope)
    v0 = along(b, shares, wave_v(b, zero(s.f0), s.f0))
    return s, v0, each(_reflection, (shares,))


def _share(b: float, slope: float) -> float:
    return 1.0 / (1.0 + slope / b)


def _reflection(share: float) -> float:
    return 2.0 * share - 1.0  # (b - G)/(b + G)


def local_answer(s: LocalModel, u2: Vector, p: SpringDamper, b: Any) -> tuple[LocalModel, Vector]:
    """Take the wave of the tick; return the one that comes back [sqrt(W)]."""
    loose = plus(s.f0, scaled(free_velocity(b, u2), s.slope))
    f = along(b, each(_share, (b.values,), s.slope), loose)
    xd, v2 = wave_velocity(b, u2, f), wave_v(b, u2, f)
    xd = xd if s.there else zero(xd)
    dissipated_j = s.dissipated_j + squared(xd) * p.damping * p.tick_s
    return s._replace(x=plus(s.x, scaled(xd, p.tick_s)), dissipated_j=dissipated_j), v2


def local_stored_j(s: LocalModel, p: SpringDamper) -> float:
    """Return the energy in the spring [J]."""
    return squared(s.x) * p.stiffness * 0.5


def changed_local(s: LocalModel, old: SpringDamper, p: SpringDamper) -> LocalModel:
    """Go on with other parameters: what the spring holds is lost."""
    if p == old:
        return s
    lost_j = s.dissipated_j + local_stored_j(s, old)
    return s._replace(x=zero(s.x), there=True, dissipated_j=lost_j)


class Bank(NamedTuple):
    """The filters of every axis, and the local model."""

    low_up: tuple[Cascade, ...]
    low_down: tuple[Cascade, ...]
    high_up: tuple[Cascade, ...]
    high_down: tuple[Cascade, ...]
    local: LocalModel
    energies: Vector  # to and from server and local model [J]


class BankFilters(NamedTuple):
    """The filters; one without sections is a wire."""

    low_up: Sections
    low_down: Sections
    high_up: Sections
    high_down: Sections
    local: SpringDamper
    tick_s: float


@port_filters.part_in.member(Bank)
def _bank_in(
    s: Bank, v: Vector, x: Vector, p: BankFilters, b: Any
) -> tuple[Bank, Vector, Vector, Vector]:
    low_in, low_out, high_in, high_out = s.energies
    energies = low_in, low_out + wave_j(v, p.tick_s), high_in, high_out
    low_down, w = columns(each(cascade, (s.low_down, v), p.low_down))
    local, v0, gains = local_offer(s.local, x, p.local, b)
    up, down = each(rest_of, (s.high_up,), p.high_up), each(rest_of, (s.high_down,), p.high_down)
    answer = plus(down, scaled(plus(v0, along(b, gains, up)), gain_of(p.high_down)))
    through = each(mul, (gains,), gain_of(p.high_up) * gain_of(p.high_down))
    s = s._replace(low_down=low_down, local=local, energies=energies)
    return s, w, answer, through


@port_filters.part_up.member(Bank)
def _bank_up(s: Bank, u: Vector, p: BankFilters, b: Any) -> tuple[Bank, Vector]:
    high_up, u2 = columns(each(cascade, (s.high_up, u), p.high_up))
    local, v2 = local_answer(s.local, u2, p.local, b)
    high_down, _ = columns(each(cascade, (s.high_down, v2), p.high_down))
    low_up, low = columns(each(cascade, (s.low_up, u), p.low_up))
    low_in, low_out, high_in, high_out = s.energies
    low_in, high_in = low_in + wave_j(low, p.tick_s), high_in + wave_j(u2, p.tick_s)
    energies = low_in, low_out, high_in, high_out + wave_j(v2, p.tick_s)
    return Bank(low_up, s.low_down, high_up, high_down, local, energies), low


@accounts.member(Bank)
def _bank_energies(s: Bank, p: BankFilters) -> Vector:
    of_local = local_stored_j(s.local, p.local), s.local.dissipated_j
    return s.energies + of_local
