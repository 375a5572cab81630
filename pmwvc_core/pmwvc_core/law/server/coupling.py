# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""How avatars and object go one step on: implicit, or with the contact force at an instant, held.

implicit: solved together by the midpoint rule; energy balances exactly. With the mean velocity v
of the object over the step and w_i = xd_si - v::

    f_i    = contact law (w_i),         w_i = sqrt(2/b_i) u_i - f_i/b_i - v
    sum f_i = m_o (v1 - v0)/h + b_o v,   v = (v0 + v1)/2
    x_o += h v,  x_si += h xd_si
    d(kinetic) + d(potential) + heat = h sum (|u_i|^2 - |v_i|^2)/2

axis by axis (:func:`.solved_axis`), or where a wave impedance couples the axes, all at once
(:mod:`.coupled_axes`). Else the object moves exactly under the held forces; energy balances only
as the step goes to zero. With the weights (old, new) [s] of old and new velocity in an avatar's
displacement: forward Euler (h, 0), backward (0, h), trapezoid (h/2, h/2).

one-step delay (App. B, Eq. 4): decoded with the force of the step before
    xd_s(n) = sqrt(2/b) u_s(n) - f_s(n-1)/b
    f_s(n)  = K [x_s(n) - x_o(n)] + B [xd_s(n) - xd_o(n)]
    Active at a wall for every K > 0 with the trapezoid (backward Euler: 4.9).
unwrapped (App. C, Eq. 4): the loop is solved per user, against the object as sampled
    xd_s = [sqrt(2 b) u_s - K (x' - x_o) + B xd_o] / (b + B + g K),     x_s = x' + g xd_s
    Passive at a wall for g = h and h/2, and for g = 0 while B >= K h/2.
one frame late (App. B, Eq. 14, the sign of f_s/b corrected; Fig. 2)
    f_s(n)    = K [x_s(n) - x_o(n)] + B [xd_s(n) - xd_o(n)],   x_s(n+1) = x_s(n) + h xd_s(n)
    xd_s(n+1) = sqrt(2/b) u_s(n) - f_s(n)/b

Equations: docs/theory.md 4.4, 4.5, 4.6, 4.7, 4.8.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.family import Family, Nothing
from pmwvc_core.law.motion import Body, BodyLaw, drifted, pushed_body
from pmwvc_core.law.server.contacts import (
    Avatar,
    Contact,
    advanced_contact,
    contact_force,
    contact_heat,
    couple,
    slid,
    touching,
)
from pmwvc_core.law.server.springs import Row, Yield, loop_force, solved_axis
from pmwvc_core.law.vectors import Vector, columns, each, minus, plus, scaled, total, zero
from pmwvc_core.law.wave.wave import Impedance, free_velocity, loaded, wave_velocity

Pushed = tuple[tuple[Avatar, ...], Body, float]
Step = tuple[tuple[Avatar, ...], Body, float, bool]


class Implicit(Nothing):
    """The coupling; it has no parameters."""


# (impedance, avatars, body, law) -> step: the same kind for all, a number or a matrix
implicit = Family("implicit")


@couple.member(Implicit)
def _implicit(p: Implicit, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Step:
    found: Step = implicit(avatars[0].impedance, avatars, body, law)
    return found


@implicit.member(Impedance)
def _alone(b: Impedance, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Step:
    rows = columns(each(_rows, (avatars,)))
    velocity, answers, settled = columns(each(solved_axis, (rows, body.xd), law))
    of_avatars = each(_by_axis, (columns(answers),))
    return carried(avatars, body, velocity, of_avatars, law, False not in settled)


def _rows(a: Avatar) -> tuple[Row, ...]:
    c, drive = a.contact, free_velocity(a.impedance, a.u)
    return each(Row, (c.springs, drive), a.present, a.impedance.b, touching(c), c.law)


def _by_axis(answers: tuple[Yield, ...]) -> Yield:
    return Yield(*columns(answers))


def carried(
    avatars: tuple[Avatar, ...], body: Body, velocity: Vector, answers: tuple[Yield, ...],
    law: BodyLaw, settled: bool,
) -> Step:  # fmt: skip
    """Move the object with a mean velocity [m/s], the avatars with their answers to it."""
    after, lost_j = drifted(body, velocity, law)
    moved, heats = columns(each(_carried, (avatars, answers), law.period_s))
    return moved, after, total(lost_j, heats), settled


def _carried(a: Avatar, answer: Yield, h: float) -> tuple[Avatar, float]:
    if not a.present:
        return a, 0.0
    xd = wave_velocity(a.impedance, a.u, answer.force)
    contact, heat_j = advanced_contact(a.contact, answer.force, answer.rate, h)
    return a._replace(xd=xd, f=answer.force, contact=contact), heat_j


# (impedance, contact, free, xd_o, weight) -> force [N] that fits xd = free - f/impedance, and a
# move of weight xd (App. C, Eq. 4)
solved_contact = Family("solved_contact")


@solved_contact.member(Impedance)
def _solved(b: Impedance, c: Contact, free: Vector, xd_o: Vector, weight: float) -> Vector:
    return each(loop_force, (c.springs, free, xd_o), b.b, weight, touching(c), c.law)


class OneStepDelay(NamedTuple):
    """Weights of old and new velocity [s]."""

    old_s: float
    new_s: float


class Unwrapped(OneStepDelay):
    """Likewise."""


class OneFrameLate(Nothing):
    """The coupling; it has no parameters."""


def weights(integrator: str, period_s: float) -> tuple[float, float]:
    """Return what old and new velocity weigh [s] in the avatar's displacement over a step."""
    new_s = {"forward_euler": 0.0, "trapezoid": 0.5, "backward_euler": 1.0}[integrator] * period_s
    return period_s - new_s, new_s


def object_pushed(avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Pushed:
    """Let the held forces move the object."""
    force = zero(body.x)
    for i in range(len(avatars)):
        if avatars[i].present:
            force = plus(force, avatars[i].f)
    body, moved, lost_j = pushed_body(body, force, law)
    avatars, dropped = columns(each(_left_behind, (avatars,), scaled(moved, -1.0)))
    return avatars, body, total(lost_j, dropped)


def _left_behind(a: Avatar, way: Vector) -> tuple[Avatar, float]:
    if not a.present:
        return a, 0.0
    contact, dropped_j = slid(a.contact, way)
    return a._replace(contact=contact), dropped_j


Stepped = tuple[Vector, Vector, Contact, float]
stepped = Family("stepped")  # (p, a, xd_o, h) -> (xd, f, contact, lost_j) of an avatar


def _stepped(a: Avatar, p: Any, xd_o: Vector, h: float) -> tuple[Avatar, float]:
    if not a.present:
        return a, 0.0
    xd, f, contact, lost_j = stepped(p, a, xd_o, h)
    return a._replace(xd=xd, f=f, contact=contact), lost_j


@couple.member(OneStepDelay, Unwrapped)
def _after_object(p: Any, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Step:
    avatars, body, lost_j = object_pushed(avatars, body, law)
    moved, lost = columns(each(_stepped, (avatars,), p, body.xd, law.period_s))
    return moved, body, total(lost_j, lost), True


@couple.member(OneFrameLate)
def _before_object(p: Any, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Step:
    moved, lost = columns(each(_stepped, (avatars,), p, body.xd, law.period_s))
    moved, body, lost_j = object_pushed(moved, body, law)
    return moved, body, total(lost_j, lost), True


@stepped.member(OneStepDelay)
def _one_step_delay(p: OneStepDelay, a: Avatar, xd_o: Vector, h: float) -> Stepped:
    xd = wave_velocity(a.impedance, a.u, a.f)
    contact, lost_j = slid(a.contact, plus(scaled(a.xd, p.old_s), scaled(xd, p.new_s)))
    rate = minus(xd, xd_o)
    return xd, contact_force(contact, rate), contact, lost_j + h * contact_heat(contact, rate)


@stepped.member(Unwrapped)
def _unwrapped(p: Unwrapped, a: Avatar, xd_o: Vector, h: float) -> Stepped:
    contact, lost_j = slid(a.contact, scaled(a.xd, p.old_s))
    free = free_velocity(a.impedance, a.u)
    f = solved_contact(a.impedance, contact, free, xd_o, p.new_s)
    xd = loaded(a.impedance, free, f)
    contact, dropped_j = slid(contact, scaled(xd, p.new_s))
    return xd, f, contact, lost_j + dropped_j + h * contact_heat(contact, minus(xd, xd_o))


@stepped.member(OneFrameLate)
def _one_frame_late(p: OneFrameLate, a: Avatar, xd_o: Vector, h: float) -> Stepped:
    rate = minus(a.xd, xd_o)
    f = contact_force(a.contact, rate)
    contact, lost_j = slid(a.contact, scaled(a.xd, h))
    lost_j += h * contact_heat(a.contact, rate)
    return wave_velocity(a.impedance, a.u, f), f, contact, lost_j
