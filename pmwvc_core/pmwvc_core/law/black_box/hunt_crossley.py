# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A soft body that stands still, after Hunt and Crossley: F = K d^n (1 + c d') while d > 0.

d is the depth in the face of the user's own side; along the face nothing holds. It never pulls.
Who comes in inside begins without force: there the face is as deep as that.
"""

from typing import NamedTuple

from pmwvc_core.law.black_box import touched
from pmwvc_core.law.black_box.touched import Vectors
from pmwvc_core.law.motion import Body
from pmwvc_core.law.vectors import Vector, columns, each, scaled, zero


class Dent(NamedTuple):
    """One user's contact with the soft body."""

    there: bool
    start: float  # depth at which the user came in [m]
    depth: float  # 0 outside [m]
    stiffness: float
    inward: Vector  # direction of the user's push


class SoftBody(NamedTuple):
    """The contacts of all users; the body, which stands still."""

    visitors: tuple[Dent, ...]
    body: Body


class SoftBodyParams(NamedTuple):
    """Exponent n, damping c [s/m], and the way from the centre to the faces [m]."""

    exponent: float
    damping: float
    face: float


@touched.visit.member(Dent)
def _visit(s: Dent, there: bool, begins: bool, position: Vector, centre: Vector) -> Dent:
    if begins:
        return Dent(True, s.inward[0] * position[0], 0.0, s.stiffness, s.inward)
    return s._replace(there=there)


@touched.moved_by.member(SoftBody)
def _moved(
    s: SoftBody, positions: Vectors, velocities: Vectors, h: float, p: SoftBodyParams
) -> tuple[SoftBody, Vectors, float]:
    dents, forces = columns(each(_pressed, (s.visitors, positions, velocities), p))
    return s._replace(visitors=dents), forces, dents_j(dents, p)


def dents_j(dents: tuple[Dent, ...], p: SoftBodyParams) -> float:
    """Return the sum of K d^(n+1)/(n+1) [J]."""
    stored_j, n = 0.0, p.exponent + 1.0
    for i in range(len(dents)):
        if dents[i].there:
            stored_j += dents[i].stiffness * dents[i].depth ** n / n
    return stored_j


def depth_at(s: Dent, position: Vector, p: SoftBodyParams) -> float:
    """Return the depth at a position; 0 outside [m]."""
    beneath = max(p.face + s.inward[0] * position[0], 0.0)
    return max(beneath - max(p.face + s.start, 0.0), 0.0)


def _pressed(s: Dent, position: Vector, xd: Vector, p: SoftBodyParams) -> tuple[Dent, Vector]:
    if not s.there:
        return s, zero(position)
    depth = depth_at(s, position, p)
    push_n = pushes_n(s, depth, s.inward[0] * xd[0], p)
    return s._replace(there=True, depth=depth), scaled(s.inward, push_n)


def pushes_n(s: Dent, depth: float, rate: float, p: SoftBodyParams) -> float:
    """Return the force inwards [N] at a depth [m] and a velocity inwards [m/s]."""
    return s.stiffness * depth**p.exponent * max(1.0 + p.damping * rate, 0.0)


@touched.local_line.member(Dent)
def _line(s: Dent, position: Vector, weight_s: float, p: SoftBodyParams) -> tuple[Vector, Vector]:
    depth = depth_at(s, position, p)
    if not s.there or depth <= 0.0:
        return zero(position), zero(position)
    elastic = s.stiffness * depth**p.exponent
    rise = p.exponent * s.stiffness * depth ** (p.exponent - 1.0) * weight_s
    slope = scaled(s.inward, s.inward[0] * (rise + p.damping * elastic))
    return scaled(s.inward, elastic), slope
