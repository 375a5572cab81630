# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments that are known by their forces only; here wall and cube, with the contact laws of
the other couplings.

The wall uses the force at the end of a step and moves by h xd (backward Euler). Of a sloped wall
the port knows K dt + B in contact (App. C Eq. 4). A driven wall moves as x = A sin(2 pi f t) along
axis 0. The cube moves by the midpoint rule with the mean force over the step (:mod:`.coupling`).
Positions and velocities are those of the avatars at the end of the step.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.black_box.secant import ExpectedForce, decoded
from pmwvc_core.law.family import Family
from pmwvc_core.law.motion import Body, BodyLaw, drifted, kinetic_j
from pmwvc_core.law.server.contacts import (
    Avatar,
    Contact,
    advanced_contact,
    attached,
    contact_energy,
    contact_force,
    detached,
    slid,
    touching,
)
from pmwvc_core.law.server.coupling import rows_of
from pmwvc_core.law.server.springs import Row, Yield, solved_axis
from pmwvc_core.law.vectors import Vector, columns, each, filled, minus, plus, scaled, zero
from pmwvc_core.law.wave.wave import Rows, free_velocity

Vectors = tuple[Vector, ...]

moved_by = Family("moved_by")  # (s, positions, velocities, h, p) -> (s, forces, stored [J])
# Of one user's contact, (s, there, begins, position, centre) -> s: there or not, or begun anew
visit = Family("visit")
local_line = Family("local_line")  # likewise, (s, position, weight_s, p) -> (force at rest, slope)


def _visited(s: Any, there: Any, begins: Any, positions: Vectors) -> Any:
    visitors = each(visit, (s.visitors, there, begins, positions), s.body.x)
    return s._replace(visitors=visitors)


# (s, there, begins, positions) -> s: who is there, who begins anew
visited = Family("visited", _visited)


class Visitor(NamedTuple):
    """One user's contact, and its avatar at the end of the last step [m]."""

    there: bool
    at: Vector
    contact: Contact


class Wall(NamedTuple):
    """A wall, which moves as it is driven."""

    visitors: tuple[Visitor, ...]
    body: Body
    time_s: float


class Swing(NamedTuple):
    """Amplitude [m], zero for a wall that stands still, and rate 2 pi f [1/s]."""

    amplitude: Vector
    rate: float


class FreeCube(NamedTuple):
    """The shared object: carried by whoever pushes it."""

    visitors: tuple[Visitor, ...]
    body: Body


@visit.member(Visitor)
def _visit(s: Visitor, there: bool, begins: bool, position: Vector, centre: Vector) -> Visitor:
    """Begin a contact without force, or end it; what its spring held is lost."""
    if begins:
        return Visitor(True, position, attached(s.contact, minus(position, centre)))
    if s.there and not there:
        return Visitor(False, s.at, detached(s.contact)[0])
    return s


@moved_by.member(Wall)
def _wall(
    s: Wall, positions: Vectors, velocities: Vectors, h: float, p: Swing
) -> tuple[Wall, Vectors, float]:
    """Follow the drive; the velocity is the mean over the step."""
    time_s = s.time_s + h
    there = scaled(p.amplitude, math.sin(p.rate * time_s))
    shift = minus(there, s.body.x)
    xd = scaled(shift, 1.0 / h)
    visitors, forces = columns(each(_pressed, (s.visitors, positions, velocities), shift, xd))
    return Wall(visitors, Body(there, xd), time_s), forces, springs_j(visitors)


def _pressed(
    s: Visitor, position: Vector, velocity: Vector, shift: Vector, xd: Vector
) -> tuple[Visitor, Vector]:
    """Return the force at the end of a step in which the wall moved by ``shift`` [m]."""
    if not s.there:
        return s, zero(position)
    contact, _ = slid(s.contact, minus(minus(position, s.at), shift))
    return Visitor(True, position, contact), contact_force(contact, minus(velocity, xd))


@moved_by.member(FreeCube)
def _cube(
    s: FreeCube, positions: Vectors, velocities: Vectors, h: float, p: BodyLaw
) -> tuple[FreeCube, Vectors, float]:
    """Return the mean forces over the step."""
    rows = columns(each(_rows, (s.visitors, positions), h))
    mean, answers, _ = columns(each(solved_axis, (rows, s.body.xd), p))
    body, _ = drifted(s.body, mean, p)
    visitors, forces = columns(each(_carried, (s.visitors, positions, columns(answers)), h))
    return FreeCube(visitors, body), forces, springs_j(visitors) + kinetic_j(body, p)


def _rows(s: Visitor, position: Vector, h: float) -> tuple[Row, ...]:
    return rows_of(s.contact, scaled(minus(position, s.at), 1.0 / h), s.there, math.inf)


def _carried(
    s: Visitor, position: Vector, answers: tuple[Yield, ...], h: float
) -> tuple[Visitor, Vector]:
    if not s.there:
        return s, zero(position)
    force, rate, _ = columns(answers)
    contact, _ = advanced_contact(s.contact, force, rate, h)
    return Visitor(True, position, contact), force


@local_line.member(Visitor)
def _line(s: Visitor, position: Vector, weight_s: float, p: Any) -> tuple[Vector, Vector]:
    rest = zero(position)
    if not s.there:
        return rest, rest
    contact, _ = slid(s.contact, minus(position, s.at))
    force = contact_force(contact, rest)
    if not touching(contact):
        return force, rest
    rise = minus(contact_force(contact, filled(rest, 1.0)), force)
    return force, plus(rise, filled(rest, contact.law.stiffness * weight_s))


def springs_j(visitors: tuple[Visitor, ...]) -> float:
    """Return the energy in all contacts [J]."""
    stored_j = 0.0
    for i in range(len(visitors)):
        stored_j += contact_energy(visitors[i].contact)  # of one who left: none
    return stored_j


class Reply(NamedTuple):
    """The answer of an environment."""

    answered: bool
    velocities: Vectors  # [m/s] of the avatars, as decoded
    ends: Vectors  # [m] of the avatars
    forces: Vectors  # [N]
    stored_j: float
    x: Vector  # of the object
    xd: Vector
    solved: bool  # with the wave: nothing is to be learned


def _exchange(
    s: Any, avatars: tuple[Avatar, ...], starts: Vectors, velocities: Vectors, p: Any
) -> tuple[Any, Reply]:
    if p.sloped:
        lines = each(local_line, (s.visitors, starts), p.new_s, p.environment)
        forces, slopes = columns(lines)
        velocities = each(solved_line, (avatars, forces, slopes), p.identity)
    positions = each(plus, (starts, each(scaled, (velocities,), p.new_s)))
    s, forces, stored_j = moved_by(s, positions, velocities, p.body.period_s, p.environment)
    return s, Reply(True, velocities, positions, forces, stored_j, s.body.x, s.body.xd, False)


# (s, avatars, starts, velocities, p) -> (s, reply): decode with the slope where there is one, step
exchange = Family("exchange", _exchange)


def solved_line(a: Avatar, force: Vector, slope: Vector, identity: Rows) -> Vector:
    """Return the velocity that fits F0 [N] and G [N s/m], a slope per axis."""
    rows = each(scaled, (identity, each(max, (slope, zero(slope)))))
    free = free_velocity(a.impedance, a.u)
    return decoded(ExpectedForce(force, rows, zero(force)), a.impedance, free)[0]
