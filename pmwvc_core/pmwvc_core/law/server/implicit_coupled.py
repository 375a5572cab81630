# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The implicit step (:mod:`.implicit`) where a wave impedance couples the axes: one vector
equation for the object.

With r(v) the force that is missing at a mean velocity v, dr/dv is symmetric and at least 2 m_o/h +
b_o, so r has one root. Newton's step c is damped by bisection on g(t) = -c . r(v - t c), which
never falls with t, until |g| has halved. It ends at rounding, or at a residual of ``TAKEN`` of the
forces once Newton's step no longer halves it.

Equations: docs/theory.md 6.6.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.server.avatar import Avatar, couple
from pmwvc_core.law.server.body import Body, BodyLaw, drifted, imbalance, mobility
from pmwvc_core.law.server.coupled_axes import CoupledAnswer, coupled_answer, loop_inverse
from pmwvc_core.law.server.implicit import ROUNDING, advanced_avatar
from pmwvc_core.law.vectors import (
    Vector,
    columns,
    dot,
    each,
    minus,
    plus,
    scaled,
    squared,
    total,
    zero,
)
from pmwvc_core.law.wave.wave import MatrixImpedance, applied, free_velocity

TAKEN = 1e-9
STEPS = 60  # of Newton's method
CUTS = 50  # of one line search
FLAT = 0.5  # of g(0): the line search is done


class ImplicitCoupled(NamedTuple):
    """The coupling; it has no parameters. All avatars' impedances are matrices."""

    none: int


class Looked(NamedTuple):
    """The equation at one velocity."""

    velocity: Vector
    answers: tuple[CoupledAnswer, ...]
    missing: Vector  # [N] r
    change: Vector  # [m/s] Newton's step
    settled: bool  # to rounding
    close: bool  # to what is taken


@couple.member(ImplicitCoupled)
def implicit_coupled(
    p: ImplicitCoupled, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw
) -> tuple[tuple[Avatar, ...], Body, float, bool]:
    """Go one step on."""
    found = _root(avatars, body, law)
    after, lost_j = drifted(body, found.velocity, law)
    moved, heats = columns(each(_advanced, (avatars, found.answers), law.period_s))
    return moved, after, total(lost_j, heats), found.close


def _advanced(a: Avatar, answer: CoupledAnswer, h: float) -> tuple[Avatar, float]:
    return advanced_avatar(a, answer.force, answer.rate, h) if a.present else (a, 0.0)


def _root(avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Looked:
    """Return the equation at its root."""
    here = _look(avatars, body.xd, body.xd, law)
    for _ in range(STEPS):
        if here.settled:
            break
        there = _downhill(avatars, body.xd, here, law)
        slow = squared(there.missing) > 0.25 * squared(here.missing)
        if there.velocity == here.velocity or (here.close and slow):
            break
        here = there
    return here


def _downhill(avatars: tuple[Avatar, ...], xd: Vector, here: Looked, law: BodyLaw) -> Looked:
    """Return the equation at the end of a damped step."""
    steep = abs(dot(here.change, here.missing))
    low, high, ratio = 0.0, 2.0, 1.0
    for _ in range(CUTS):
        found = _look(avatars, minus(here.velocity, scaled(here.change, ratio)), xd, law)
        gain = -dot(here.change, found.missing)  # g(t)
        if here.close or found.settled:
            return found
        if gain <= 0.0 and (gain >= -FLAT * steep or ratio >= 1.0):
            return found
        if gain <= 0.0:
            low = ratio
        else:
            high = ratio
        ratio = 0.5 * (low + high)
    return _look(avatars, minus(here.velocity, scaled(here.change, low)), xd, law)


def _look(avatars: tuple[Avatar, ...], velocity: Vector, xd: Vector, law: BodyLaw) -> Looked:
    answers = each(_answer, (avatars,), velocity, law.period_s)
    force, slopes, size = zero(velocity), answers[0].slope, 0.0
    slopes = each(scaled, (slopes,), 0.0)
    for i in range(len(avatars)):
        if avatars[i].present:
            push, slope = answers[i].force, answers[i].slope
            free = minus(free_velocity(avatars[i].impedance, avatars[i].u), velocity)
            force, slopes = plus(force, push), each(plus, (slopes, slope))
            size += math.sqrt(squared(push)) + math.sqrt(squared(each(_size, (slope,), free)))
    missing, gives = each(imbalance, (xd, velocity, force), law), mobility(0.0, law)
    numbers = avatars[0].impedance.numbers
    inverse = loop_inverse(each(scaled, (slopes,), gives), numbers)
    step = applied(inverse, scaled(missing, gives))
    scale = math.sqrt(squared(velocity)) + gives * size
    settled = math.sqrt(squared(step)) <= ROUNDING * scale
    close = settled or gives * math.sqrt(squared(missing)) <= TAKEN * scale
    return Looked(velocity, answers, missing, step, settled, close)


def _answer(a: Avatar, velocity: Vector, h: float) -> CoupledAnswer:
    b: MatrixImpedance = a.impedance
    free = minus(free_velocity(b, a.u), velocity)
    if not a.present:
        return CoupledAnswer(zero(velocity), free, each(scaled, (b.b,), 0.0))
    return coupled_answer(a.contact, free, b, h)


def _size(row: Vector, free: Vector) -> float:
    return dot(each(abs, (row,)), each(abs, (free,)))
