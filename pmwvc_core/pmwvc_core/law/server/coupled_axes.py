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
from pmwvc_core.law.vectors import Vector, columns, dot, each, plus, scaled, times, zero
from pmwvc_core.law.wave.wave import Impedance, MatrixImpedance, Rows, applied, loaded, outer

# (impedance, contact, free, xd_o, weight) -> force [N] that fits xd = free - f/impedance
solved_contact = Family("solved_contact")


class CoupledAnswer(NamedTuple):
    """The answer of a contact to the velocity that its avatar would have without it."""

    force: Vector  # [N] on the object
    rate: Vector  # [m/s] relative velocity, mean over the step
    slope: Rows  # [N s/m] by how much the force falls per velocity of the object


def loop_inverse(loop: Rows, numbers: tuple[int, ...]) -> Rows:
    """Return (1 + loop)^-1, a matrix of so many axes."""
    n = len(numbers)
    a = np.eye(n)
    for i in range(n):
        for j in range(n):
            a[i, j] += loop[i][j]
    return each(_row, (numbers,), np.linalg.inv(a), numbers)


def _row(row: int, a: np.ndarray, numbers: tuple[int, ...]) -> Vector:
    return each(_element, (numbers,), a, row)


def _element(column: int, a: np.ndarray, row: int) -> float:
    return float(a[row, column])


def _gain(s: Spring, gain: float, held: bool) -> float:
    return gain if held and not s.one_sided else 0.0


def _loose(s: Spring, xd_o: float, law: ContactLaw, held: bool) -> float:
    acts = held and not s.one_sided
    return law.stiffness * s.deflection - law.damping * xd_o if acts else 0.0


def across(
    c: Contact, gain: float, free: Vector, xd_o: Vector, b: MatrixImpedance
) -> tuple[Vector, Vector, Rows, float, float]:
    """Eliminate f = K e - B xd_o + gain xd along the axes that have no face. Return A (l + G free)
    [N], A e_0, A G [N s/m], what they take from the velocity along axis 0 [m/s], and b' [N s/m].
    """
    mobility, acts = b.inverse, touching(c)
    gains = each(_gain, (c.springs,), gain, acts)
    loose = each(_loose, (c.springs, xd_o), c.law, acts)
    a = loop_inverse(each(scaled, (mobility, gains)), b.numbers)
    held, lean = applied(a, plus(loose, times(gains, free))), columns(a)[0]
    slope = each(times, (a,), gains)
    return held, lean, slope, dot(mobility[0], held), 1.0 / dot(mobility[0], lean)


def coupled_answer(c: Contact, free: Vector, b: MatrixImpedance, h: float) -> CoupledAnswer:
    """Return the mean force over a step of h [s] for which rate = free - B^-1 force."""
    law = c.law
    gain = 0.5 * law.stiffness * h + law.damping
    held, lean, slope, less, alone = across(c, gain, free, zero(free), b)
    if not c.springs[0].one_sided:
        return CoupledAnswer(held, loaded(b, free, held), slope)
    along = spring_answer(c.springs[0], free[0] - less, alone, h, touching(c), law)
    force = _with_face(held, lean, along.force, b)
    rate = each(_faced, (loaded(b, free, force), b.numbers), along.rate)
    slope = each(plus, (slope, outer(lean, scaled(lean, along.slope))))
    return CoupledAnswer(force, rate, slope)


def _with_face(held: Vector, lean: Vector, push: float, b: MatrixImpedance) -> Vector:
    """Return the force with that of the face, which is exact: where it is zero, nothing pushes."""
    return each(_faced, (plus(held, scaled(lean, push)), b.numbers), push)


def _faced(signal: float, number: int, along: float) -> float:
    return along if number == 0 else signal


@solved_contact.member(Impedance)
def _solved(b: Impedance, c: Contact, free: Vector, xd_o: Vector, weight: float) -> Vector:
    return contact_unwrapped(c, free, xd_o, b.b, weight)


@solved_contact.member(MatrixImpedance)
def _coupled(b: MatrixImpedance, c: Contact, free: Vector, xd_o: Vector, weight: float) -> Vector:
    law, first = c.law, c.springs[0]
    gain = law.damping + weight * law.stiffness
    held, lean, _, less, alone = across(c, gain, free, xd_o, b)
    if not first.one_sided:
        return held
    push = unwrapped_axis(first, free[0] - less, xd_o[0], alone, weight, touching(c), law)
    return _with_face(held, lean, push, b)
