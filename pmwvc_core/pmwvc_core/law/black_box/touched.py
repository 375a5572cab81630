# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments that are known by their forces only; here wall and cube, with the contact laws of
the other couplings. Some answer the impedance of the ports: no force is guessed, none comes late.
To all others every avatar moves with the velocity decoded, whatever the force.

The wall uses the force at the end of a step and moves by h xd (backward Euler). Of a sloped wall
the port knows K dt + B in contact (App. C Eq. 4). A driven wall moves as x = A sin(2 pi f t) along
axis 0. The cube, and the wall that answers an impedance, which is a cube of infinite mass, take
the avatars into their implicit step (:mod:`pmwvc_core.law.server.coupling`). Positions and
velocities are those of the avatars at the end of the step.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.black_box.secant import ExpectedForce, decoded
from pmwvc_core.law.family import Family, same
from pmwvc_core.law.motion import Body, kinetic_j
from pmwvc_core.law.server.contacts import Avatar, contact_force, slid, springs_j, touching
from pmwvc_core.law.server.coupling import implicit
from pmwvc_core.law.vectors import Vector, columns, each, filled, minus, plus, scaled, zero
from pmwvc_core.law.wave.wave import Impedance, Rows, free_velocity

Avatars = tuple[Avatar, ...]
Vectors = tuple[Vector, ...]

# What moves with a velocity that is given, whatever the force: that is its wave.
COMMANDED = Impedance(math.inf, 0.0, math.inf, 1.0, (math.inf,))

# (s, visitors, p) -> (s, avatars, stored [J]): one step on; p are the parameters of the port
moved_by = Family("moved_by")
touches = Family("touches", lambda s, user, pushed: pushed)  # (s, user, is it pushed) -> touches
visited = Family("visited", same)  # (s, there, begins, positions) -> s: who is there, begins anew


class Visitors(NamedTuple):
    """Avatars behind their impedances; where they are, and would be without a new velocity [m]."""

    avatars: Avatars
    at: Vectors
    starts: Vectors


class Wall(NamedTuple):
    """A wall, which moves as it is driven."""

    body: Body
    time_s: float


class Swing(NamedTuple):
    """Amplitude [m], zero for a wall that stands still, and rate 2 pi f [1/s]."""

    amplitude: Vector
    rate: float


class MetObject(NamedTuple):
    """The shared object, carried by whoever pushes it, or a wall; they answer an impedance."""

    body: Body


class FreeCube(MetObject):
    """The shared object, which does not."""


@moved_by.member(Wall)
def _wall(s: Wall, visitors: Visitors, p: Any) -> tuple[Wall, Avatars, float]:
    """Follow the drive; the velocity is the mean over the step."""
    swing, time_s = p.environment, s.time_s + p.body.period_s
    there = scaled(swing.amplitude, math.sin(swing.rate * time_s))
    shift = minus(there, s.body.x)
    xd = scaled(shift, 1.0 / p.body.period_s)
    moved = each(_pressed, visitors, shift, xd, p)
    return Wall(Body(there, xd), time_s), moved, springs_j(moved)


def _pressed(a: Avatar, at: Vector, start: Vector, shift: Vector, xd: Vector, p: Any) -> Avatar:
    """Return the force at the end of a step in which the wall moved by ``shift`` [m]."""
    if not a.present:
        return a._replace(xd=a.u, f=zero(a.u))
    contact, _ = slid(a.contact, minus(_way(a, at, start, p), shift))
    return a._replace(xd=a.u, f=contact_force(contact, minus(a.u, xd)), contact=contact)


def _way(a: Avatar, at: Vector, start: Vector, p: Any) -> Vector:
    return minus(plus(start, scaled(a.u, p.new_s)), at)


@moved_by.member(MetObject)
def _object(s: Any, visitors: Visitors, p: Any) -> tuple[Any, Avatars, float]:
    """Return mean velocities and forces over the step."""
    avatars = visitors.avatars
    moved, body, _, _ = implicit(avatars[0].impedance, avatars, s.body, p.environment)
    return s._replace(body=body), moved, springs_j(moved) + kinetic_j(body, p.environment)


@moved_by.member(FreeCube)
def _cube(s: FreeCube, visitors: Visitors, p: Any) -> tuple[Any, Avatars, float]:
    """Have each avatar go its way with its mean velocity."""
    means = visitors._replace(avatars=each(_mean, visitors, p))
    s, moved, stored_j = _object(s, means, p)
    return s, each(_pushed, (visitors.avatars, moved)), stored_j


def _mean(a: Avatar, at: Vector, start: Vector, p: Any) -> Avatar:
    return a._replace(u=scaled(_way(a, at, start, p), 1.0 / p.body.period_s))


def _pushed(a: Avatar, moved: Avatar) -> Avatar:
    return a._replace(xd=a.u, f=moved.f, contact=moved.contact)


def _lines(s: Any, visitors: Visitors, p: Any) -> tuple[Vectors, Vectors]:
    lines: tuple[Vectors, Vectors] = columns(each(_line, visitors, p))
    return lines


def _line(a: Avatar, at: Vector, start: Vector, p: Any) -> tuple[Vector, Vector]:
    rest = zero(a.u)
    if not a.present:
        return rest, rest
    contact, _ = slid(a.contact, minus(start, at))
    force = contact_force(contact, rest)
    if not touching(contact):
        return force, rest
    rise = minus(contact_force(contact, filled(rest, 1.0)), force)
    return force, plus(rise, filled(rest, contact.law.stiffness * p.new_s))


# (s, visitors, p) -> forces at rest, slopes
local_lines = Family("local_lines", _lines)


class Reply(NamedTuple):
    """The answer of an environment."""

    answered: bool
    avatars: Avatars  # with velocities [m/s] as decoded, and forces [N]
    ends: Vectors  # [m] of the avatars
    stored_j: float
    x: Vector  # of the object
    xd: Vector
    solved: bool  # with the wave: nothing is to be learned


def _exchange(s: Any, visitors: Visitors, velocities: Vectors, p: Any) -> tuple[Any, Reply]:
    if p.sloped:
        forces, slopes = local_lines(s, visitors, p)
        velocities = each(solved_line, (visitors.avatars, forces, slopes), p.identity)
    commanded = each(_commanded, (visitors.avatars, velocities))
    return met(s, visitors._replace(avatars=commanded), velocities, p)


def _commanded(a: Avatar, velocity: Vector) -> Avatar:
    return a._replace(impedance=COMMANDED, u=velocity)


# (s, visitors, velocities, p) -> (s, reply): decode with the slope where there is one, step
exchange = Family("exchange", _exchange)


@exchange.member(MetObject)
def met(s: Any, visitors: Visitors, velocities: Vectors, p: Any) -> tuple[Any, Reply]:
    """Step with avatars behind their impedances, which decide on the velocities."""
    s, moved, stored_j = moved_by(s, visitors, p)
    ends = each(moved_on, (moved, visitors.starts), p.new_s)
    return s, Reply(True, moved, ends, stored_j, s.body.x, s.body.xd, p.sloped)


def moved_on(a: Avatar, x: Vector, weight_s: float) -> Vector:
    """Return where an avatar at x [m] is after so long [s]."""
    return plus(x, scaled(a.xd, weight_s))


def solved_line(a: Avatar, force: Vector, slope: Vector, identity: Rows) -> Vector:
    """Return the velocity that fits F0 [N] and G [N s/m], a slope per axis."""
    rows = each(scaled, (identity, each(max, (slope, zero(slope)))))
    free = free_velocity(a.impedance, a.u)
    return decoded(ExpectedForce(force, rows, zero(force)), a.impedance, free)[0]
