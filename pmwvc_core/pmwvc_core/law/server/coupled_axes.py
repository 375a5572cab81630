# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contacts behind a wave port whose impedance B couples the axes.

The laws are those of :mod:`.contacts` in the loop xd = free - Y f with Y = B^-1. Along every axis
but that of a face they are linear, f = l + G xd with G diagonal, so with the force f_0 of a face
along axis 0, whose unit vector is e_0::

    f = A (l + G free) + A e_0 f_0,                            A = (1 + G Y)^-1
    xd_0 = (free_0 - Y_0 A (l + G free)) - f_0/b',             1/b' = Y_0 A e_0

which leaves the law along axis 0 behind a number b' > 0 (a Schur complement). The force falls with
the velocity of the object by A G + (A e_0) s_0 (A e_0)^T, s_0 the slope of the law along axis 0.

Equations: docs/theory.md 6.4, 6.5.
"""

from typing import NamedTuple

import numpy as np

from pmwvc_core.law.family import Family
from pmwvc_core.law.server.contacts import Contact, contact_unwrapped, touching
from pmwvc_core.law.server.springs import ContactLaw, Spring, spring_answer, unwrapped_axis
from pmwvc_core.law.vectors import Vector, dot, each, plus, scaled, times
from pmwvc_core.law.wave.wave import Impedance, MatrixImpedance, Rows, applied, loaded

# (impedance, contact, free, xd_o, weight) -> force [N] that fits xd = free - f/impedance
solved_contact = Family("solved_contact")


class CoupledAnswer(NamedTuple):
    """The answer of a contact to the velocity that its avatar would have without it."""

    force: Vector  # [N] on the object
    rate: Vector  # [m/s] relative velocity, mean over the step
    slope: Rows  # [N s/m] by how much the force falls per velocity of the object


class Across(NamedTuple):
    """The linear axes once they are eliminated."""

    held: Vector  # [N] A (l + G free)
    lean: Vector  # A e_0
    slope: Rows  # A G [N s/m]
    less: float  # [m/s] what they take from the velocity along axis 0
    b: float  # [N s/m] b'


def inverse(rows: Rows, numbers: tuple[int, ...]) -> Rows:
    """Return the inverse of a matrix of so many axes, by elimination with pivots."""
    n = len(numbers)
    a = np.zeros((n, 2 * n))
    for i in range(n):
        a[i, n + i] = 1.0
        for j in range(n):
            a[i, j] = rows[i][j]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        for j in range(2 * n):
            kept = a[k, j]
            a[k, j] = a[best, j]
            a[best, j] = kept
        pivot = a[k, k]
        for j in range(2 * n):
            a[k, j] /= pivot
        for i in range(n):
            if i != k:
                factor = a[i, k]
                for j in range(2 * n):
                    a[i, j] -= factor * a[k, j]
    return each(_inverted, (numbers,), a, numbers)


def _inverted(row: int, a: np.ndarray, numbers: tuple[int, ...]) -> Vector:
    return each(_element, (numbers,), a, row, len(numbers))


def _element(column: int, a: np.ndarray, row: int, first: int) -> float:
    return float(a[row, first + column])


def _gain(s: Spring, gain: float, held: bool) -> float:
    return gain if held and not s.one_sided else 0.0


def _loose(s: Spring, stiffness: float, held: bool) -> float:
    return stiffness * s.deflection if held and not s.one_sided else 0.0


def _loop(row: Vector, gain: float, number: int, numbers: tuple[int, ...]) -> Vector:
    return each(of_loop, (row, numbers), gain, number)


def of_loop(y: float, column: int, gain: float, row: int) -> float:
    """Return an element of 1 + gain Y."""
    return gain * y + (1.0 if column == row else 0.0)


def _first(row: Vector) -> float:
    return row[0]


def across(loose: Vector, gains: Vector, free: Vector, b: MatrixImpedance) -> Across:
    """Eliminate f = loose + gains xd along the axes that have no face."""
    mobility = b.inverse
    a = inverse(each(_loop, (mobility, gains, b.numbers), b.numbers), b.numbers)
    held, lean = applied(a, plus(loose, times(gains, free))), each(_first, (a,))
    slope = each(times, (a,), gains)
    return Across(held, lean, slope, dot(mobility[0], held), 1.0 / dot(mobility[0], lean))


def coupled_answer(c: Contact, free: Vector, b: MatrixImpedance, h: float) -> CoupledAnswer:
    """Return the mean force over a step of h [s] for which rate = free - B^-1 force."""
    law, held = c.law, touching(c)
    gains = each(_gain, (c.springs,), 0.5 * law.stiffness * h + law.damping, held)
    loose = each(_loose, (c.springs,), law.stiffness, held)
    rest = across(loose, gains, free, b)
    if not c.springs[0].one_sided:
        rate = loaded(b, free, rest.held)
        return CoupledAnswer(rest.held, rate, rest.slope)
    along = spring_answer(c.springs[0], free[0] - rest.less, rest.b, h, held, law)
    force = _with_face(rest, along.force, b)
    rate = each(_faced, (loaded(b, free, force), b.numbers), along.rate)
    slope = each(_leaning, (rest.slope, rest.lean), rest.lean, along.slope)
    return CoupledAnswer(force, rate, slope)


def _with_face(rest: Across, push: float, b: MatrixImpedance) -> Vector:
    """Return the force with that of the face, which is exact: where it is zero, nothing pushes."""
    return each(_faced, (plus(rest.held, scaled(rest.lean, push)), b.numbers), push)


def _faced(signal: float, number: int, along: float) -> float:
    return along if number == 0 else signal


def _leaning(row: Vector, lean: float, course: Vector, slope: float) -> Vector:
    return plus(row, scaled(course, slope * lean))


@solved_contact.member(Impedance)
def _solved(b: Impedance, c: Contact, free: Vector, xd_o: Vector, weight: float) -> Vector:
    return contact_unwrapped(c, free, xd_o, b.b, weight)


@solved_contact.member(MatrixImpedance)
def _coupled(b: MatrixImpedance, c: Contact, free: Vector, xd_o: Vector, weight: float) -> Vector:
    law, held = c.law, touching(c)
    gains = each(_gain, (c.springs,), law.damping + weight * law.stiffness, held)
    loose = each(_sliding, (c.springs, xd_o), law, held)
    rest = across(loose, gains, free, b)
    first = c.springs[0]
    if not first.one_sided:
        return rest.held
    push = unwrapped_axis(first, free[0] - rest.less, xd_o[0], rest.b, weight, held, law)
    return _with_face(rest, push, b)


def _sliding(s: Spring, xd_o: float, law: ContactLaw, held: bool) -> float:
    return _loose(s, law.stiffness, held) - _gain(s, law.damping, held) * xd_o
