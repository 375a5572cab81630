# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The spring and damper of a contact along one axis, and its force f on the object.

Two-sided (App. B, Eq. 3): f = K e + B e', of which ``held`` tells whether it acts.

The face of a grip: an avatar pushes it and never pulls. With the depth p in the face (negative
outside) and the inward direction n = -side::

    N = max(0, K p + B p')  while p > 0, else 0        f = n N

The mean force of a step from p0 to p1 = p0 + h w is the difference quotient of the potential
phi(p) = K max(p, 0)^2 / 2, and the damper acts on the part of the way inside::

    N = max(0, [phi(p1) - phi(p0)] / (p1 - p0) + B [max(p1, 0) - max(p0, 0)] / h)

With w = c - N/b it has exactly one solution, piece by piece a quadratic (p, c and w count
inwards), and the object's equation along an axis one root, found by Newton's method within a
bracket. Equations: docs/theory.md 4.1, 4.3.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.motion import BodyLaw, imbalance, mobility
from pmwvc_core.law.vectors import each

ROUNDING = 8.0 * 2.0**-52
NEWTON = 20  # steps before halving alone is trusted
LIMIT = 90  # then the bracket is as narrow as numbers are


class ContactLaw(NamedTuple):
    """The law of a contact, and the face of a grip."""

    stiffness: float  # K [N/m]
    damping: float  # B [N s/m]
    inward: float  # direction, 1 or -1
    face: float  # from the centre of the object [m]
    gap: float  # least distance from it at the start [m]


class Spring(NamedTuple):
    """A contact along one axis [m]."""

    deflection: float
    rest: float
    one_sided: bool  # of a grip, along axis 0


class Yield(NamedTuple):
    """The answer to an avatar's free velocity: numbers, or vectors and a matrix."""

    force: Any  # [N] on the object
    rate: Any  # [m/s] relative velocity, mean over the step
    slope: Any  # [N s/m] by how much the force falls per velocity of the object


def depth(s: Spring, law: ContactLaw) -> float:
    """Return how deep an avatar is in the face; negative outside [m]."""
    return law.inward * s.deflection


def stored(s: Spring, law: ContactLaw) -> float:
    """Return the energy of the spring along an axis [J]: K e^2/2, of a grip while it is inside."""
    inside = max(depth(s, law), 0.0) if s.one_sided else s.deflection
    return 0.5 * law.stiffness * inside * inside


def force_at(s: Spring, rate: float, held: bool, law: ContactLaw) -> float:
    """Return the force [N] at the present deflection and a relative velocity [m/s]."""
    return loop_force(s, rate, 0.0, math.inf, 0.0, held, law)


def loop_force(
    s: Spring, free: float, xd_o: float, b: float, weight: float, held: bool, law: ContactLaw
) -> float:
    """Return the force [N] that fits xd = free - f/b and a move of weight xd; of a grip 0 unless
    the avatar, pushed back, ends inside: the sampled law jumps where the damper begins to act.
    """
    gain = law.damping + weight * law.stiffness
    force = law.stiffness * s.deflection + gain * free - law.damping * xd_o
    force /= 1.0 + gain / b
    acts = held
    if s.one_sided:
        deep = s.deflection + weight * (free - force / b)
        acts = law.inward * force > 0.0 and law.inward * deep > 0.0
    return force if acts else 0.0


def spring_answer(
    s: Spring, free: float, b: float, h: float, held: bool, law: ContactLaw
) -> Yield:
    """Return the mean force of a step of h [s] for rate = free - force/b; b may be infinite."""
    inward = law.inward if s.one_sided else 1.0
    p0, c = inward * s.deflection, inward * free
    push = Yield(0.0, c, 0.0)
    if p0 > 0.0 or not s.one_sided:
        gain, pull = 0.5 * law.stiffness * h + law.damping, law.stiffness * p0
        ratio = 1.0 + gain / b  # inside at both ends: N = K p0 + (K h/2 + B) w
        push = Yield((pull + gain * c) / ratio, (c - pull / b) / ratio, gain)
        if s.one_sided and not p0 + h * push.rate >= 0.0:
            push = _leaving(p0, c, b, h, law)
    elif p0 + h * c > 0.0:
        push = _entering(p0, c, b, h, law)
    acts = push.force > 0.0 if s.one_sided else held
    if not acts:
        return Yield(0.0, free, 0.0)
    return Yield(inward * push.force, inward * push.rate, push.slope / (1.0 + push.slope / b))


def _leaving(p0: float, c: float, b: float, h: float, law: ContactLaw) -> Yield:
    """Inside at the start only: N = K p0^2/(2 h s) - B p0/h, s = -w, s^2 + beta s = gamma."""
    k, damping = law.stiffness, law.damping
    beta = c + damping * p0 / (h * b)
    gamma = 0.5 * k * p0 * p0 / (h * b)
    size = math.sqrt(beta * beta + 4.0 * gamma)
    speed = 2.0 * gamma / (beta + size) if beta > 0.0 else 0.5 * (size - beta)
    way = h * speed
    ratio = p0 / way if way > 0.0 else p0  # of the way that is inside
    normal = 0.5 * k * p0 * ratio - damping * p0 / h
    return Yield(normal, -speed, 0.5 * h * k * ratio * ratio)


def _entering(p0: float, c: float, b: float, h: float, law: ContactLaw) -> Yield:
    """Inside at the end only: p1 is the positive root of a p^2 - 2 q p = g, g >= 0 (over b). The
    only small difference in it is the depth without resistance, p0 + h c > 0.
    """
    k, damping = law.stiffness, law.damping
    reach = max(p0 + h * c, 0.0)
    a = 1.0 + (0.5 * h * k + damping) / b
    q = 0.5 * ((1.0 + damping / b) * p0 + reach)
    g = -reach * min(p0, 0.0)
    size = math.sqrt(q * q + a * g)
    p1 = (q + size) / a
    if q <= 0.0:
        less = size - q
        p1 = g / less if less > 0.0 else g
    way = p1 - p0 if p1 > p0 else 1.0
    ratio = p1 / way  # of the way that is inside
    normal = 0.5 * k * p1 * ratio + damping * p1 / h
    return Yield(normal, way / h, 0.5 * h * k * ratio * (2.0 - ratio) + damping)


class Row(NamedTuple):
    """One avatar along one axis."""

    spring: Spring
    drive: float  # [m/s] velocity without the contact
    present: bool
    b: float  # [N s/m]; infinite where the avatar moves as it is told
    held: bool
    law: ContactLaw


def solved_axis(
    rows: tuple[Row, ...], xd: float, law: BodyLaw
) -> tuple[float, tuple[Yield, ...], bool]:
    """Return the object's mean velocity [m/s], the answers, and whether they fit to rounding."""
    velocity, settled = xd, False
    low = high = xd
    answers = each(_answer, (rows,), velocity, law.period_s)
    for turn in range(LIMIT):
        force, slope, size = 0.0, 0.0, 0.0  # size of the terms that may cancel [N]
        for i in range(len(rows)):
            push, fall = answers[i].force, answers[i].slope  # zero of who is not there
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


def _answer(row: Row, velocity: float, h: float) -> Yield:
    if not row.present:
        return Yield(0.0, 0.0, 0.0)
    return spring_answer(row.spring, row.drive - velocity, row.b, h, row.held, row.law)
