# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The filters between a device and its wave port, the loop through them, and the velocity filter
among them, which feeds back the high-pass part of the outgoing wave (App. D).

A filter lets through w of the returning wave v, and answers the outgoing wave u_m within the tick,
with v0 + g u_m, |g| < 1 for each eigenvalue of the impedance, so that

    v_m = w + v0 + g u_m,   u_m = (sqrt(2b) xd - w - v0)/(1 + g)

Order within a tick: ``answered``, then ``wave_shortened`` where the limits let another force
through, and ``filters_up``. In the velocity filter s is the share fed back (half in App. D):

exact (App. D Fig. 1)
    v_m = w + s H_HP u_m: F_m = b (1 - s H)/(1 + s H) xd - sqrt(2b) w/(1 + s H)
equivalent (App. D Fig. 2, Eq. 3 and 2)
    F_m = b (1 - 2 s H_HP) xd - sqrt(2b) v_m, u_m = sqrt(2b) xd - v_m: active, b (2 s H_HP xd) xd
complementary (ours)
    v_m = H_1 w + s H_2 H_2 u_m, and H_1 u_m goes on, with |H_1|^2 + |H_2|^2 = 1. Passive at every
    tick for s <= 1.

Equations: docs/theory.md 7.1, 7.2, 7.3, 7.7.
"""

import math
from operator import add
from typing import Any, NamedTuple

from pmwvc_core.law.family import Family, accounts, passed
from pmwvc_core.law.vectors import Vector, columns, dot, each, filled, minus, plus, scaled, squared
from pmwvc_core.law.wave.filter_and_hold import Cascade, Sections, cascade, gain_of, rest_of
from pmwvc_core.law.wave.wave import along, damper, wave_u


def _shortening(u: Vector, held: Vector, answer: Vector, missing: float) -> tuple[float, float]:
    """Return the longest s <= 1 with |s u|^2 <= |held + s answer|^2 + twice the power, and what is
    missing then: a s^2 - 2 c s <= p with a = |u|^2 - |answer|^2 > 0, c = held . answer.
    """
    a, c = squared(u) - squared(answer), dot(held, answer)
    most = a - 2.0 * c + missing  # without what is missing: what p has to be for s = 1
    ratio = 1.0
    if missing < 0.0:
        ratio = c + math.sqrt(max(c * c + a * most, 0.0))
        ratio = max(min(ratio / a if a > 0.0 else ratio, 1.0), 0.0)
    return ratio, max((a * ratio - 2.0 * c) * ratio - most, 0.0)


def _wave_shortened(
    s: Any, u_m: Vector, v_m: Vector, missing: float, b: Any
) -> tuple[Vector, Vector, float]:
    ratio, deficit = _shortening(u_m, v_m, filled(u_m, 0.0), missing)
    return scaled(u_m, ratio), v_m, deficit


def _bare(s: Any, v: Vector, x: Vector, xd: Vector, p: Any, b: Any) -> tuple[Any, Vector, Vector]:
    return s, v, xd


def _no_answer(s: Any, v: Vector, x: Vector, p: Any, b: Any) -> tuple[Any, Vector, Vector, Vector]:
    return s, v, filled(x, 0.0), filled(b.values, 0.0)


def _closed(gain: float) -> float:
    return gain / (1.0 + gain)


# (s, v, x, xd, p, b) -> (s, v_m, velocity for the force): the wave at the port, with the
# answer to its own u_m
answered = Family("answered", _bare)
# (s, u_m, v_m, missing, b) -> (u_m, v_m, deficit): the longest wave that is paid for with
# so much more than twice its own power [W], and what is not paid for then
wave_shortened = Family("wave_shortened", _wave_shortened)
filters_up = Family("filters_up", passed)  # (s, u, p) -> (s, what of the outgoing wave goes on)
# (s, v, x, p, b) -> (s, w, v0, gains): what it lets through of the wave, and its answer
# v0 + g u to the one of the tick
part_in = Family("part_in", _no_answer)
part_up = Family("part_up", passed)  # (s, u, p, b) -> (s, what of the outgoing wave goes on)
part_velocity = Family("part_velocity", passed)  # (s, xd, p, b) -> (s, velocity for the force)


class Filtered(NamedTuple):
    """A port with filters."""

    near: Any  # to the device: the velocity filter
    far: Any
    held: Vector  # w + v0 [sqrt(W)]: what is in v_m whatever u_m is
    gains: Vector  # of their answer


class FilteredParams(NamedTuple):
    """Their parameters."""

    near: Any
    far: Any
    impedance: Any


@answered.member(Filtered)
def _filtered(
    s: Filtered, v: Vector, x: Vector, xd: Vector, p: FilteredParams, b: Any
) -> tuple[Filtered, Vector, Vector]:
    far, v, answer, gains = part_in(s.far, v, x, p.far, b)
    near, v, own, others = part_in(s.near, v, x, p.near, b)
    near, for_force = part_velocity(near, xd, p.near, b)
    held, gains = plus(v, plus(answer, own)), each(add, (gains, others))
    natural = wave_u(b, xd, held)
    v_m = plus(held, along(b, each(_closed, (gains,)), natural))
    return Filtered(near, far, held, gains), v_m, for_force


@wave_shortened.member(Filtered)
def _filtered_shortened(
    s: Filtered, u_m: Vector, v_m: Vector, missing: float, b: Any
) -> tuple[Vector, Vector, float]:
    answer = along(b, s.gains, u_m)
    ratio, deficit = _shortening(u_m, s.held, answer, missing)
    return scaled(u_m, ratio), plus(s.held, scaled(answer, ratio)), deficit


@filters_up.member(Filtered)
def _filtered_up(s: Filtered, u: Vector, p: FilteredParams) -> tuple[Filtered, Vector]:
    near, u = part_up(s.near, u, p.near, p.impedance)
    far, u = part_up(s.far, u, p.far, p.impedance)
    return s._replace(near=near, far=far), u


@accounts.member(Filtered)
def _filtered_energies(s: Filtered, p: FilteredParams) -> Vector:
    return accounts(s.near, p.near) + accounts(s.far, p.far)


class InWaves(NamedTuple):
    """The exact and the complementary velocity filter: cascades of every axis."""

    up: tuple[Cascade, ...]
    down: tuple[Cascade, ...]
    back: tuple[Cascade, ...]
    w: Vector  # from the server [sqrt(W)]
    passed: Vector  # what of it passed
    kept_j: float


class InForce(NamedTuple):
    """The equivalent one: the high-pass filter of every axis, and the energy kept [J]."""

    high: tuple[Cascade, ...]
    kept_j: float


class VelocityParams(NamedTuple):
    """Parameters of a velocity filter."""

    high: Sections  # of what comes back
    low: Sections  # H_1 of both waves; without sections a wire
    share: float  # s
    tick_s: float


@part_in.member(InWaves)
def _velocity_in(
    s: InWaves, v: Vector, x: Vector, p: VelocityParams, b: Any
) -> tuple[InWaves, Vector, Vector, Vector]:
    down, passed = columns(each(cascade, (s.down, v), p.low))
    rest = scaled(each(rest_of, (s.back,), p.high), p.share)
    s = s._replace(down=down, w=v, passed=passed)
    return s, passed, rest, filled(b.values, p.share * gain_of(p.high))


@part_up.member(InWaves)
def _velocity_up(s: InWaves, u: Vector, p: VelocityParams, b: Any) -> tuple[InWaves, Vector]:
    up, on = columns(each(cascade, (s.up, u), p.low))
    high, y = columns(each(cascade, (s.back, u), p.high))
    back = plus(s.passed, scaled(y, p.share))
    kept = squared(u) - squared(on) + squared(s.w) - squared(back)
    return InWaves(up, s.down, high, s.w, s.passed, s.kept_j + kept * (0.5 * p.tick_s)), on


@part_velocity.member(InForce)
def _in_force(s: InForce, xd: Vector, p: VelocityParams, b: Any) -> tuple[InForce, Vector]:
    high, y = columns(each(cascade, (s.high, xd), p.high))
    less = scaled(y, 2.0 * p.share)
    kept_j = s.kept_j - dot(damper(b, less), xd) * p.tick_s
    return InForce(high, kept_j), minus(xd, less)


@accounts.member(InWaves, InForce)
def _velocity_energies(s: Any, p: VelocityParams) -> Vector:
    return (s.kept_j,)
