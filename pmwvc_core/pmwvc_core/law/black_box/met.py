# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Wall, cube and soft body that answer an impedance: no force is guessed, none comes late.

Wall and cube take the ports into their implicit step (:mod:`pmwvc_core.law.server.coupling`). A
soft body has a port b' along axis 0, 1/b' = (B^-1)_00, whose free velocity is q. Its force at the
end of a step h fits the velocity w, all inwards::

    K p^n max(1 + c w, 0) = b' (q - w),   p = max(p0 + h w, 0)

The left side is convex and never falls with w: from no force on, Newton's method comes to the one
root from below. Equations: docs/theory.md 5.15.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.black_box.hunt_crossley import Dent, dents_j, depth_at, pushes_n
from pmwvc_core.law.black_box.touched import Reply, Vectors, Visitor, exchange, springs_j
from pmwvc_core.law.motion import Body, kinetic_j
from pmwvc_core.law.server.contacts import Avatar
from pmwvc_core.law.server.coupling import implicit
from pmwvc_core.law.vectors import Vector, columns, each, plus, scaled, zero
from pmwvc_core.law.wave.wave import free_velocity, loaded

ROUNDING, ROUNDS = 2.0**-50, 200


class MetObject(NamedTuple):
    """Wall or cube, and the contacts of all users."""

    visitors: tuple[Visitor, ...]
    body: Body


class MetSoftBody(NamedTuple):
    """Likewise, a soft body."""

    visitors: tuple[Dent, ...]
    body: Body


@exchange.member(MetObject)
def _object(
    s: MetObject, avatars: tuple[Avatar, ...], starts: Vectors, velocities: Vectors, p: Any
) -> tuple[MetObject, Reply]:
    touching = each(_touching, (avatars, s.visitors))
    moved, body, _, _ = implicit(avatars[0].impedance, touching, s.body, p.environment)
    visitors, ends, rates, forces = columns(each(_moved, (s.visitors, moved, starts), p.new_s))
    stored_j = springs_j(visitors) + kinetic_j(body, p.environment)
    return MetObject(visitors, body), Reply(
        True, rates, ends, forces, stored_j, body.x, body.xd, True
    )


def _touching(a: Avatar, s: Visitor) -> Avatar:
    return a._replace(present=s.there, contact=s.contact)


def _moved(
    s: Visitor, a: Avatar, start: Vector, h: float
) -> tuple[Visitor, Vector, Vector, Vector]:
    end = plus(start, scaled(a.xd, h))
    return s._replace(at=end, contact=a.contact), end, a.xd, a.f


@exchange.member(MetSoftBody)
def _soft(
    s: MetSoftBody, avatars: tuple[Avatar, ...], starts: Vectors, velocities: Vectors, p: Any
) -> tuple[MetSoftBody, Reply]:
    users = s.visitors, avatars, starts
    dents, ends, rates, forces = columns(each(_pressed, users, p.new_s, p.environment))
    stored_j = dents_j(dents, p.environment)
    return s._replace(visitors=dents), Reply(
        True, rates, ends, forces, stored_j, s.body.x, s.body.xd, True
    )


def _pressed(
    s: Dent, a: Avatar, start: Vector, h: float, p: Any
) -> tuple[Dent, Vector, Vector, Vector]:
    free, n = free_velocity(a.impedance, a.u), p.exponent
    mobility = -s.inward[0] * loaded(a.impedance, zero(free), s.inward)[0]  # [m/s/N] 1/b'
    push_n, depth = 0.0, 0.0
    for _ in range(ROUNDS):
        rate = s.inward[0] * free[0] - mobility * push_n
        depth = depth_at(s, plus(start, scaled(s.inward, h * rate)), p)
        missing = pushes_n(s, depth, rate, p) - push_n
        if not s.there or missing <= ROUNDING * push_n:
            break
        damped = 1.0 + p.damping * rate
        slope = s.stiffness * depth ** (n - 1.0) * (n * h * damped + p.damping * depth)
        push_n += missing / (1.0 + mobility * slope)
    force = scaled(s.inward, push_n)
    xd = loaded(a.impedance, free, force)
    return s._replace(depth=depth), plus(start, scaled(xd, h)), xd, force
