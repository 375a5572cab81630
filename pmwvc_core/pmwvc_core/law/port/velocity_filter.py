# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity filter by feeding back the high-pass part of the outgoing wave (App. D).

exact (App. D Fig. 1)
    v_m = w + s H_HP u_m with w the wave from the server, solved together with u_m = sqrt(2b) xd -
    v_m: F_m = b (1 - s H)/(1 + s H) xd - sqrt(2b) w/(1 + s H). Passive with the low-pass filter
    behind it where ``|H_LP| + s |H_HP| <= 1`` (:mod:`pmwvc_core.wave.design.branches`).
equivalent (App. D Fig. 2, Eq. 3 and 2)
    F_m = b (1 - 2 s H_HP) xd - sqrt(2b) v_m, u_m = sqrt(2b) xd - v_m. Generates b (2 s H_HP xd)
    xd, which the account shows.
complementary (ours)
    v_m = H_1 w + s H_2 H_2 u_m, and H_1 u_m goes on, with |H_1|^2 + |H_2|^2 = 1. Passive at every
    tick for s <= 1.

s is the share that comes back (half in App. D); ``kept_j`` the energy that a filter has kept.

Equations: docs/theory.md 7.1, 7.2, 7.3.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.port import port_filters
from pmwvc_core.law.vectors import Vector, columns, dot, each, minus, plus, scaled, squared
from pmwvc_core.law.wave.cascade import (
    Cascade,
    Sections,
    cascade,
    gain_of,
    rest_of,
    resting_cascade,
    sections_of,
)
from pmwvc_core.law.wave.wave import damper
from pmwvc_core.params import MasterParams
from pmwvc_core.wave.design.velocity_filter_design import high_pass, low_pass


class Exact(NamedTuple):
    """The high-pass filter of every axis, and the wave from the server."""

    high: tuple[Cascade, ...]
    w: Vector  # [sqrt(W)]
    kept_j: float


class InForce(NamedTuple):
    """The high-pass filter of every axis."""

    high: tuple[Cascade, ...]
    kept_j: float


class Complementary(NamedTuple):
    """The filters of every axis; the wave from the server, and what of it passed [sqrt(W)]."""

    up: tuple[Cascade, ...]
    down: tuple[Cascade, ...]
    first: tuple[Cascade, ...]
    second: tuple[Cascade, ...]
    w: Vector
    passed: Vector
    kept_j: float


class VelocityParams(NamedTuple):
    """Filters, the share s that comes back, and the tick."""

    high: Sections
    low: Sections
    share: float
    tick_s: float


def velocity_params(master: MasterParams) -> VelocityParams:
    """Return the parameters of the velocity filter of a master."""
    low = sections_of(low_pass(master)) if master.velocity_filter.splits else ()
    high = sections_of(high_pass(master))
    return VelocityParams(high, low, master.velocity_filter.share, master.tick_s)


def resting_velocity(
    master: MasterParams, p: VelocityParams, axes: int
) -> Exact | InForce | Complementary:
    """Return the velocity filter of a master at rest."""
    high, rest = (resting_cascade(p.high),) * axes, (0.0,) * axes
    if master.velocity_filter.splits:
        low = (resting_cascade(p.low),) * axes
        return Complementary(low, low, high, high, rest, rest, 0.0)
    return InForce(high, 0.0) if master.velocity_filter.in_force else Exact(high, rest, 0.0)


@port_filters.part_down.member(Exact)
def _exact_down(s: Exact, v: Vector, p: VelocityParams) -> tuple[Exact, Vector]:
    return s._replace(w=v), v


@port_filters.part_offer.member(Exact)
def _exact_offer(
    s: Exact, x: Vector, p: VelocityParams, impedance: Any
) -> tuple[Exact, Vector, Vector]:
    gains = port_filters.same_gain(impedance, p.share * gain_of(p.high))
    return s, scaled(each(rest_of, (s.high,), p.high), p.share), gains


@port_filters.part_up.member(Exact)
def _exact_up(s: Exact, u: Vector, p: VelocityParams, impedance: Any) -> tuple[Exact, Vector]:
    high, y = columns(each(cascade, (s.high, u), p.high))
    back = plus(s.w, scaled(y, p.share))
    kept_j = s.kept_j + (squared(s.w) - squared(back)) * (0.5 * p.tick_s)
    return Exact(high, s.w, kept_j), u


@port_filters.part_velocity.member(InForce)
def _in_force(s: InForce, xd: Vector, p: VelocityParams, impedance: Any) -> tuple[InForce, Vector]:
    high, y = columns(each(cascade, (s.high, xd), p.high))
    less = scaled(y, 2.0 * p.share)
    kept_j = s.kept_j - dot(damper(impedance, less), xd) * p.tick_s
    return InForce(high, kept_j), minus(xd, less)


@port_filters.part_down.member(Complementary)
def _complementary_down(
    s: Complementary, v: Vector, p: VelocityParams
) -> tuple[Complementary, Vector]:
    down, passed = columns(each(cascade, (s.down, v), p.low))
    return s._replace(down=down, w=v, passed=passed), passed


@port_filters.part_offer.member(Complementary)
def _complementary_offer(
    s: Complementary, x: Vector, p: VelocityParams, impedance: Any
) -> tuple[Complementary, Vector, Vector]:
    gain = gain_of(p.high)
    gains = port_filters.same_gain(impedance, p.share * gain * gain)
    first, second = each(rest_of, (s.first,), p.high), each(rest_of, (s.second,), p.high)
    return s, scaled(plus(scaled(first, gain), second), p.share), gains


@port_filters.part_up.member(Complementary)
def _complementary_up(
    s: Complementary, u: Vector, p: VelocityParams, impedance: Any
) -> tuple[Complementary, Vector]:
    up, on = columns(each(cascade, (s.up, u), p.low))
    first, y = columns(each(cascade, (s.first, u), p.high))
    second, y = columns(each(cascade, (s.second, y), p.high))
    back = plus(s.passed, scaled(y, p.share))
    kept = squared(u) - squared(on) + squared(s.w) - squared(back)
    kept_j = s.kept_j + kept * (0.5 * p.tick_s)
    return s._replace(up=up, first=first, second=second, kept_j=kept_j), on


@port_filters.part_energies.member(Exact, InForce, Complementary)
def _energies(s: Any, p: VelocityParams) -> Vector:
    return (s.kept_j,)
