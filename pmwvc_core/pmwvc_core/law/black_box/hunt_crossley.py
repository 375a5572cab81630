# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A soft body that stands still, after Hunt and Crossley: F = K d^n (1 + c d') while d > 0.

d is the depth in the face of the user's own side; along the face nothing holds. It never pulls.
Who comes in inside begins without force: there the face is as deep as that.

A port behind an impedance B is one behind b' along axis 0, 1/b' = (B^-1)_00, whose free velocity
is q; b' is infinite where that is the avatar's velocity, whatever the force. The force at the end
of a step h fits the velocity w, all inwards::

    K p^n max(1 + c w, 0) = b' (q - w),   p = max(p0 + h w, 0)

The left side is convex and never falls with w: from no force on, Newton's method comes to the one
root from below.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.black_box import touched
from pmwvc_core.law.black_box.touched import Avatars, Vectors, Visitors
from pmwvc_core.law.motion import Body
from pmwvc_core.law.server.contacts import Avatar
from pmwvc_core.law.vectors import Vector, columns, each, scaled, total, zero
from pmwvc_core.law.wave.wave import free_velocity, loaded

ROUNDING, ROUNDS = 2.0**-50, 200


class SoftBody(NamedTuple):
    """Where each user came in, along axis 0 [m]; the body, which stands still."""

    starts: Vector
    body: Body


class MetSoftBody(SoftBody):
    """One that answers the impedance of the ports."""


class SoftBodyParams(NamedTuple):
    """Exponent n, damping c [s/m], and the way from the centre to the faces [m]."""

    exponent: float
    damping: float
    face: float


@touched.visited.member(SoftBody, MetSoftBody)
def _visited(s: Any, there: tuple[bool, ...], begins: tuple[bool, ...], places: Vectors) -> Any:
    return s._replace(starts=each(_start, (s.starts, begins, places)))


def _start(start: float, begins: bool, place: Vector) -> float:
    return place[0] if begins else start


touched.exchange.member(MetSoftBody)(touched.met)


@touched.moved_by.member(SoftBody, MetSoftBody)
def _moved(s: Any, visitors: Visitors, p: Any) -> tuple[Any, Avatars, float]:
    users = s.starts, visitors.avatars, visitors.starts
    moved, stored = columns(each(_pressed, users, p, p.environment))
    return s, moved, total(0.0, stored)


def _depth(came: float, x: float, inward: float, p: SoftBodyParams) -> float:
    return max(max(p.face + inward * x, 0.0) - max(p.face + inward * came, 0.0), 0.0)


def _pressed(
    came: float, a: Avatar, start: Vector, port: Any, p: SoftBodyParams
) -> tuple[Avatar, float]:
    """Return also the energy K d^(n+1)/(n+1) [J]."""
    free, h = free_velocity(a.impedance, a.u), port.new_s
    n, k = p.exponent, a.contact.law.stiffness
    side = a.contact.law.inward
    inward = scaled(port.identity[0], side)
    mobility = -side * loaded(a.impedance, zero(free), inward)[0]  # [m/s/N] 1/b'
    push_n, depth = 0.0, 0.0
    for _ in range(ROUNDS):
        rate = side * free[0] - mobility * push_n
        depth = _depth(came, start[0] + side * (h * rate), side, p) if a.present else 0.0
        damped = max(1.0 + p.damping * rate, 0.0)
        missing = k * depth**n * damped - push_n
        if missing <= ROUNDING * push_n:
            break
        slope = k * depth ** (n - 1.0) * (n * h * damped + p.damping * depth)
        push_n += missing / (1.0 + mobility * slope)
    force = scaled(inward, push_n)
    moved = a._replace(xd=loaded(a.impedance, free, force), f=force)
    return moved, k * depth ** (n + 1.0) / (n + 1.0)


@touched.local_lines.member(SoftBody)
def _lines(s: SoftBody, visitors: Visitors, p: Any) -> tuple[Vectors, Vectors]:
    users = s.starts, visitors.avatars, visitors.starts
    lines: tuple[Vectors, Vectors] = columns(each(_line, users, p, p.environment))
    return lines


def _line(
    came: float, a: Avatar, start: Vector, port: Any, p: SoftBodyParams
) -> tuple[Vector, Vector]:
    side, k = a.contact.law.inward, a.contact.law.stiffness
    depth = _depth(came, start[0], side, p)
    if not a.present or depth <= 0.0:
        return zero(start), zero(start)
    elastic = k * depth**p.exponent
    rise = p.exponent * k * depth ** (p.exponent - 1.0) * port.new_s
    along = port.identity[0]
    return scaled(along, side * elastic), scaled(along, rise + p.damping * elastic)
