# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Compensations of the energy of late decoding (App. C section 5). Each
takes the waves of all users in a step, and returns those to be sent.

as published (Eq. 14, 15), for comparison only: it injects energy (J taken for W)
    dE(n) = dE(n-1) + T [F(n) F(n-1) - F(n)^2]/b        of each user, from the start [J]
    v     = sgn(v) sqrt(v^2 - 2 dE(n))                  where dE(n) < 0
corrected in its sign: it only shortens waves; a deficit below zero is credit
    deficit(n) = deficit(n-1) + sum over users [F(n)^2 - F(n) F'(n)]/b - pay(n-1)          [W]
    pay(n)  = min(max(deficit, 0), sum |v|^2/2),   each v in proportion to its length
port ledger: all users together get back no more than they gave, and a declared allowance
    tank += h sum |u_i|^2/2,   cost = h sum |v_i|^2/2
    v_i  *= sqrt(tank/cost)    where cost > tank, all by the same factor
    tank -= h sum |v_i|^2/2,   tank = min(tank, cap)
    Up to ``allowance_w`` is added at any time, up to ``allowance_j`` in all. Cap: what can still
    come out, or ``cap_j`` where the environment does not report its stored energy.

Equations: docs/theory.md 5.6, 5.7, 5.8.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.family import Family, accounts
from pmwvc_core.law.vectors import Vector, columns, each, scaled, squared
from pmwvc_core.law.wave.wave import wave_j


class Pair(NamedTuple):
    """The signals of one user's port in a step; zeros where nobody is there."""

    u: Vector  # [sqrt(W)] received
    v: Vector  # [sqrt(W)] to be returned
    late_w: float  # F . (xd as it should have been - xd as decoded), mostly < 0


class Terms(NamedTuple):
    """Parameters of any compensation: time step, allowance and cap."""

    period_s: float
    grant_j: float  # most that is taken from the allowance in a step
    allowance_j: float
    cap_j: float


class AsPublished(NamedTuple):
    """Energy of late decoding of each user [J]."""

    late_j: Vector


class Corrected(NamedTuple):
    """What later waves still have to pay [W]; below zero: credit."""

    deficit_w: float


class JointLedger(NamedTuple):
    """One tank for all users [J]."""

    tank_j: float  # may still be given back
    granted_j: float  # taken from the allowance
    capped_j: float  # received, but not kept


Waves = tuple[Vector, ...]
Pairs = tuple[Pair, ...]


def _shortened(wave: Pair, ratio: float) -> Vector:
    return scaled(wave.v, ratio)


def _untreated(s: Any, waves: Pairs, held_j: float, p: Terms) -> tuple[Any, Waves]:
    return s, each(_shortened, (waves,), 1.0)


# (s, waves, held_j, p) -> (s, waves to send); ``held_j`` is what can still come out of
# environment and decoding, below zero where the environment does not report it
compensated = Family("compensated", _untreated)


@compensated.member(AsPublished)
def _printed(s: AsPublished, waves: Pairs, held_j: float, p: Terms) -> tuple[AsPublished, Waves]:
    late_j, longer = columns(each(_longer, (s.late_j, waves), p.period_s))
    return AsPublished(late_j), longer


def _longer(late_j: float, wave: Pair, h: float) -> tuple[float, Vector]:
    late_j += h * wave.late_w
    old = squared(wave.v)
    ratio = math.sqrt((old - 2.0 * min(late_j, 0.0)) / old) if old > 0.0 else 0.0
    return late_j, scaled(wave.v, ratio)


@compensated.member(Corrected)
def _corrected(s: Corrected, waves: Pairs, held_j: float, p: Terms) -> tuple[Corrected, Waves]:
    deficit_w, have_w = s.deficit_w, 0.0
    for i in range(len(waves)):
        deficit_w -= waves[i].late_w
        have_w += 0.5 * squared(waves[i].v)
    pay_w = min(max(deficit_w, 0.0), have_w)
    ratio = math.sqrt((have_w - pay_w) / have_w) if have_w > 0.0 else 1.0
    return Corrected(deficit_w - pay_w), each(_shortened, (waves,), ratio)


@accounts.member(Corrected)
def _deficit(s: Corrected, p: Terms) -> Vector:
    return (p.period_s * s.deficit_w,)


@compensated.member(JointLedger)
def _ledger(s: JointLedger, waves: Pairs, held_j: float, p: Terms) -> tuple[JointLedger, Waves]:
    have_j, cost_j = s.tank_j, 0.0
    for i in range(len(waves)):
        have_j += wave_j(waves[i].u, p.period_s)
        cost_j += wave_j(waves[i].v, p.period_s)
    grant_j = min(max(cost_j - have_j, 0.0), min(p.grant_j, p.allowance_j - s.granted_j))
    have_j += grant_j
    ratio, left_j = 1.0, have_j - cost_j
    if cost_j > have_j:
        ratio, left_j = math.sqrt(have_j / cost_j), 0.0
    tank_j = min(left_j, held_j if held_j >= 0.0 else p.cap_j)
    s = JointLedger(tank_j, s.granted_j + grant_j, s.capped_j + (left_j - tank_j))
    return s, each(_shortened, (waves,), ratio)


@accounts.member(JointLedger)
def _tank(s: JointLedger, p: Terms) -> Vector:
    return (s.tank_j, s.granted_j, s.capped_j)
