# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contacts behind a wave port whose impedance B couples the axes, and the implicit step there.

The laws are those of :mod:`.contacts` in the loop xd = free - Y f with Y = B^-1. Along every axis
but that of a face they are linear, f = l + G xd with G diagonal, so with the force f_0 of a face
along axis 0, whose unit vector is e_0::

    f = A (l + G free) + A e_0 f_0,                            A = (1 + G Y)^-1
    xd_0 = (free_0 - Y_0 A (l + G free)) - f_0/b',             1/b' = Y_0 A e_0

which leaves the law along axis 0 behind a number b' > 0 (a Schur complement). The force falls with
the velocity of the object by A G + (A e_0) s_0 (A e_0)^T, s_0 the slope of the law along axis 0.

The implicit step (:mod:`.coupling`) is one vector equation. With r(v) the force that is missing at
a mean velocity v, Newton's step c is damped by bisection on g(t) = -c . r(v - t c), which never
falls with t, until |g| has halved. It ends at rounding, or at a residual of ``TAKEN`` of the
forces once the step no longer halves it. Equations: docs/theory.md 6.4, 6.5, 6.6.
"""

from typing import NamedTuple

import numpy as np

from pmwvc_core.law.motion import Body, BodyLaw, imbalance, mobility
from pmwvc_core.law.server.contacts import Avatar, Contact, touching
from pmwvc_core.law.server.coupling import Step, carried, implicit, solved_contact
from pmwvc_core.law.server.springs import ROUNDING, Spring, Yield, loop_force, spring_answer
from pmwvc_core.law.vectors import Vector, dot, each, length, minus, plus, row, scaled, times, zero
from pmwvc_core.law.wave.wave import ImpedanceMatrix, Rows, applied, free_velocity, loaded, outer


def loop_inverse(loop: Rows, numbers: tuple[int, ...]) -> Rows:
    """Return (1 + loop)^-1, a matrix of so many axes."""
    inverse = np.linalg.inv(np.eye(len(numbers)) + np.array(loop))
    return each(row, (numbers,), inverse, numbers)


def _first(row: Vector) -> float:
    return row[0]


def _gain(s: Spring, gain: float, held: bool) -> float:
    return gain if held and not s.one_sided else 0.0


def _loose(s: Spring, xd_o: float, stiffness: float, damping: float, held: bool) -> float:
    return stiffness * s.deflection - damping * xd_o if held and not s.one_sided else 0.0


def across(
    c: Contact, gain: float, free: Vector, xd_o: Vector, b: ImpedanceMatrix
) -> tuple[Vector, Vector, Rows, float, float]:
    """Eliminate f = K e - B xd_o + gain xd along the axes that have no face. Return A (l + G free)
    [N], A e_0, A G [N s/m], what they take from the velocity along axis 0 [m/s], and b' [N s/m].
    """
    mobility, acts = b.inverse, touching(c)
    gains = each(_gain, (c.springs,), gain, acts)
    loose = each(_loose, (c.springs, xd_o), c.law.stiffness, c.law.damping, acts)
    a = loop_inverse(each(scaled, (mobility, gains)), b.numbers)
    held, lean = applied(a, plus(loose, times(gains, free))), each(_first, (a,))
    slope = each(times, (a,), gains)
    return held, lean, slope, dot(mobility[0], held), 1.0 / dot(mobility[0], lean)


def coupled_answer(c: Contact, free: Vector, b: ImpedanceMatrix, h: float) -> Yield:
    """Return the mean force over a step of h [s] for which rate = free - B^-1 force."""
    law = c.law
    gain = 0.5 * law.stiffness * h + law.damping
    held, lean, slope, less, alone = across(c, gain, free, zero(free), b)
    if not c.springs[0].one_sided:
        return Yield(held, loaded(b, free, held), slope)
    along = spring_answer(c.springs[0], free[0] - less, alone, h, touching(c), law)
    force = _with_face(held, lean, along.force, b)
    rate = each(_faced, (loaded(b, free, force), b.numbers), along.rate)
    slope = each(plus, (slope, outer(lean, scaled(lean, along.slope))))
    return Yield(force, rate, slope)


def _with_face(held: Vector, lean: Vector, push: float, b: ImpedanceMatrix) -> Vector:
    """Return the force with that of the face, which is exact: where it is zero, nothing pushes."""
    return each(_faced, (plus(held, scaled(lean, push)), b.numbers), push)


def _faced(signal: float, number: int, along: float) -> float:
    return along if number == 0 else signal


@solved_contact.member(ImpedanceMatrix)
def _coupled(b: ImpedanceMatrix, c: Contact, free: Vector, xd_o: Vector, weight: float) -> Vector:
    law, first = c.law, c.springs[0]
    gain = law.damping + weight * law.stiffness
    held, lean, _, less, alone = across(c, gain, free, xd_o, b)
    if not first.one_sided:
        return held
    push = loop_force(first, free[0] - less, xd_o[0], alone, weight, touching(c), law)
    return _with_face(held, lean, push, b)


TAKEN = 1e-9
STEPS = 60  # of Newton's method
CUTS = 50  # of one line search
FLAT = 0.5  # of g(0): the line search is done


class Looked(NamedTuple):
    """The equation at one velocity."""

    velocity: Vector
    answers: tuple[Yield, ...]
    missing: Vector  # [N] r
    change: Vector  # [m/s] Newton's step
    settled: bool  # to rounding
    close: bool  # to what is taken


@implicit.member(ImpedanceMatrix)
def _implicit(b: ImpedanceMatrix, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Step:
    here = _look(avatars, body.xd, body.xd, law)
    for _ in range(STEPS):
        if here.settled:
            break
        there = _downhill(avatars, body.xd, here, law)
        slow = length(there.missing) > 0.5 * length(here.missing)
        if there.velocity == here.velocity or (here.close and slow):
            break
        here = there
    return carried(avatars, body, here.velocity, here.answers, law, here.close)


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
        push, slope = answers[i].force, answers[i].slope  # zero of who is not there
        free = minus(free_velocity(avatars[i].impedance, avatars[i].u), velocity)
        force, slopes = plus(force, push), each(plus, (slopes, slope))
        size += length(push) + length(each(_size, (slope,), free))
    missing, gives = each(imbalance, (xd, velocity, force), law), mobility(0.0, law)
    numbers = avatars[0].impedance.numbers
    inverse = loop_inverse(each(scaled, (slopes,), gives), numbers)
    step = applied(inverse, scaled(missing, gives))
    scale = length(velocity) + gives * size
    settled = length(step) <= ROUNDING * scale
    close = settled or gives * length(missing) <= TAKEN * scale
    return Looked(velocity, answers, missing, step, settled, close)


def _answer(a: Avatar, velocity: Vector, h: float) -> Yield:
    b: ImpedanceMatrix = a.impedance
    free = minus(free_velocity(b, a.u), velocity)
    if not a.present:
        return Yield(zero(velocity), free, each(scaled, (b.b,), 0.0))
    return coupled_answer(a.contact, free, b, h)


def _size(row: Vector, free: Vector) -> float:
    return dot(each(abs, (row,)), each(abs, (free,)))
