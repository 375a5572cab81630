# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Implicit: avatars and object solved together by the midpoint rule; energy balances exactly.

With the mean velocity v of the object over the step and w_i = xd_si - v::

    f_i    = contact law (w_i),         w_i = sqrt(2/b_i) u_i - f_i/b_i - v
    sum f_i = m_o (v1 - v0)/h + b_o v,   v = (v0 + v1)/2
    x_o += h v,  x_si += h xd_si
    d(kinetic) + d(potential) + heat = h sum (|u_i|^2 - |v_i|^2)/2

Each f_i falls with v, at most by b_i per m/s, so the object's equation has one root, found by
Newton's method within a bracket, axis by axis (one step where all contacts are two-sided). Where a
wave impedance couples the axes: :mod:`.coupled_axes`.

Equations: docs/theory.md 4.4, 4.5.
"""

from typing import NamedTuple

from pmwvc_core.law.motion import Body, BodyLaw, drifted, imbalance, mobility
from pmwvc_core.law.server.contacts import Avatar, Contact, advanced_contact, couple, touching
from pmwvc_core.law.server.springs import Answer, ContactLaw, Spring, spring_answer
from pmwvc_core.law.vectors import Vector, columns, each, total
from pmwvc_core.law.wave.wave import free_velocity, wave_velocity

ROUNDING = 8.0 * 2.0**-52
NEWTON = 20  # steps before halving alone is trusted
LIMIT = 90  # then the bracket is as narrow as numbers are


class Implicit(NamedTuple):
    """The coupling; it has no parameters."""

    none: int


class Row(NamedTuple):
    """One avatar along one axis."""

    spring: Spring
    drive: float  # [m/s] velocity without the contact
    present: bool
    b: float  # [N s/m]; infinite where the avatar moves as it is told
    held: bool
    law: ContactLaw


@couple.member(Implicit)
def implicit(
    p: Implicit, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw
) -> tuple[tuple[Avatar, ...], Body, float, bool]:
    """Go one step on."""
    rows = columns(each(_rows, (avatars,)))
    velocity, answers, settled = columns(each(solved_axis, (rows, body.xd), law))
    after, lost_j = drifted(body, velocity, law)
    moved, heats = columns(each(_advanced, (avatars, columns(answers)), law.period_s))
    every = True
    for i in range(len(settled)):
        every = every and settled[i]
    return moved, after, total(lost_j, heats), every


def _rows(a: Avatar) -> tuple[Row, ...]:
    return rows_of(a.contact, free_velocity(a.impedance, a.u), a.present, a.impedance.b)


def rows_of(c: Contact, drive: Vector, present: bool, b: float) -> tuple[Row, ...]:
    """Return an avatar along every axis, from what :class:`Row` holds of it."""
    return each(Row, (c.springs, drive), present, b, touching(c), c.law)


def solved_axis(
    rows: tuple[Row, ...], xd: float, law: BodyLaw
) -> tuple[float, tuple[Answer, ...], bool]:
    """Return the object's mean velocity along an axis [m/s], the answers of all contacts, and
    whether they fit to rounding.
    """
    velocity, settled = xd, False
    low = high = xd
    answers = each(_answer, (rows,), velocity, law.period_s)
    for turn in range(LIMIT):
        force, slope, size = 0.0, 0.0, 0.0  # size of the terms that may cancel [N]
        for i in range(len(rows)):
            if rows[i].present:
                push, fall = answers[i].force, answers[i].slope
                force += push
                slope += fall
                size += abs(push) + fall * abs(rows[i].drive - velocity)
        missing, gives = imbalance(xd, velocity, force, law), mobility(slope, law)
        change = missing * gives
        if abs(change) <= ROUNDING * (abs(velocity) + gives * size):
            settled = True
            break
        if turn == 0:
            other = velocity - missing * mobility(0.0, law)
            low, high = min(velocity, other), max(velocity, other)
        elif missing < 0.0:
            low = velocity
        else:
            high = velocity
        velocity -= change
        if turn >= NEWTON or velocity < low or velocity > high:
            velocity = 0.5 * (low + high)
        answers = each(_answer, (rows,), velocity, law.period_s)
    return velocity, answers, settled


def _answer(row: Row, velocity: float, h: float) -> Answer:
    if not row.present:
        return Answer(0.0, 0.0, 0.0)
    return spring_answer(row.spring, row.drive - velocity, row.b, h, row.held, row.law)


def _advanced(a: Avatar, answers: tuple[Answer, ...], h: float) -> tuple[Avatar, float]:
    if not a.present:
        return a, 0.0
    force, rate, _ = columns(answers)
    return advanced_avatar(a, force, rate, h)


def advanced_avatar(a: Avatar, force: Vector, rate: Vector, h: float) -> tuple[Avatar, float]:
    """Move an avatar with mean force [N] and relative velocity [m/s] of a step; return the heat
    [J].
    """
    xd = wave_velocity(a.impedance, a.u, force)
    contact, heat_j = advanced_contact(a.contact, force, rate, h)
    return a._replace(xd=xd, f=force, contact=contact), heat_j
