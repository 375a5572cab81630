# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The slope of a black box, learned from its own answers, one user at a time; and what its port
knows of one user.

The port decodes with a line through the last force F- at the last position x-::

    F' = F- + K^ (x - x-),   x = position + w xd,   hence   F' = F0 + G xd,   G = w K^

K^ is symmetric positive semidefinite, a slowly decaying maximum of the secant of force over
position. With dx = x - x-, dF = F - F-, s = (dF - K^ dx) . dx, for steps that are not much shorter
than recent ones::

    s > 0:  K^ += s p p^T/(p . dx)^2,   p = dF - K^ dx, or dx where p is nearly across
    s < 0:  K^ -= c (K^ dx)(K^ dx)^T/(dx . K^ dx),   c = min(0.1, -s/(dx . K^ dx))

Where all steps in contact were much shorter than dx, K^ was noise: c is not limited. A step into a
one-sided contact that is stiffer than known counts ``LEAP`` times its secant. Up to |K^| T = b/2
F' = F-: decoding late is passive there (2B <= 0.35 b). An environment in which a user moved
without force is taken as one-sided: its force keeps its sign, and where it ended there is a face.
A force that jumps while hardly anything moved is a fault; with s the longest way in this step of
any avatar or of the object (fading over 0.5 s), n steps after the last force used, accepted is::

    |F - F-| <= 100 (b/T) s + b n ``KICK_M_S``

Equations: docs/theory.md 5.3, 5.5, 5.13.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.server.contacts import Avatar
from pmwvc_core.law.server.server_port import UserPort
from pmwvc_core.law.vectors import Vector, dot, each, length, minus, plus, scaled, within, zero
from pmwvc_core.law.wave.wave import Rows, applied, damper, free_velocity, outer, wave_velocity

DECAY = 0.9  # of a slope per step that measures less
SHORT = 0.3  # length of a step that is too short, relative to recent ones
LEAST_M = 1e-12
NEARLY_ACROSS = 0.5  # cosine
SOFT = 0.5  # K T/b up to which the force of the step before will do
LEAP = 7.0  # slope taken where a contact begins, over what the step measured
LARGEST = 100.0  # G relative to b
NOTHING = 1e-290  # squared length at which a solution is found


class ExpectedForce(NamedTuple):
    """The force that a user expects: F0 + G xd, not across its own direction."""

    force: Vector  # [N] F0
    slope: Rows  # [N s/m] G
    along: Vector  # direction that the force keeps; zero: any


class Secant(NamedTuple):
    """The slope learned of the environment at one user's avatar."""

    scale: float  # b/T, smallest wave impedance over the period [N/m]
    position: Vector
    force: Vector
    slope: Rows  # K^
    longest: float  # recent step, decaying [m]
    one_sided: bool
    face_at: Vector  # [m] last position with contact
    face_force: Vector  # [N] there; zero: no face is known
    expected: bool  # decoded with a force


def resting_secant(position: Vector, scale: float, expected: bool) -> Secant:
    """Begin to learn at a position."""
    rest = zero(position)
    return Secant(scale, position, rest, outer(rest, rest), 0.0, False, rest, rest, expected)


def learned(s: Secant) -> float:
    """Return |K^| T/b of the slope; where a contact chatters, (K T + 2B)/b."""
    size = 0.0
    for row in s.slope:
        size += dot(row, row)
    return math.sqrt(size) / s.scale


def ratio_in_use(s: Secant) -> float:
    """Return |K^| T/b, zero where decoding late will do."""
    ratio = learned(s)
    return ratio if ratio > SOFT else 0.0


def line(s: Secant, position: Vector, weight: float) -> ExpectedForce:
    """Return what to expect where the avatar would be without its new velocity [m]."""
    if ratio_in_use(s) <= 0.0:
        return ExpectedForce(s.force, each(scaled, (s.slope,), 0.0), zero(s.force))
    if s.force != zero(s.force):
        found = plus(s.force, applied(s.slope, minus(position, s.position)))
        kept = _direction(s.force) if s.one_sided else zero(found)
        return ExpectedForce(found, each(scaled, (s.slope,), weight), kept)
    along = _direction(s.face_force)
    rise = applied(s.slope, minus(position, s.face_at))
    found = scaled(along, dot(along, plus(s.face_force, rise)))
    stiffness = weight * dot(along, applied(s.slope, along))
    kept = along if s.one_sided else zero(found)
    return ExpectedForce(found, outer(along, scaled(along, stiffness)), kept)


def decoded(to: ExpectedForce, impedance: Any, free: Vector) -> tuple[Vector, bool]:
    """Return xd [m/s] from that without a force, and whether it was decoded with one: of (B + G)
    xd = B free - F0 by conjugate gradients, exact after a step per axis, and again for rounding.
    """
    left = way = minus(damper(impedance, free), to.force)
    xd, size = zero(left), dot(left, left)
    for _ in range(2 * len(left)):
        if size > NOTHING:
            image = plus(damper(impedance, way), applied(to.slope, way))
            step = size / dot(way, image)
            xd, left = plus(xd, scaled(way, step)), minus(left, scaled(image, step))
            after = dot(left, left)
            way, size = plus(left, scaled(way, after / size)), after
    force = plus(to.force, applied(to.slope, xd))
    pushes = dot(to.along, force) >= 0.0 and force != zero(force)
    return (xd if pushes else free), pushes


def learn(s: Secant, position: Vector, force: Vector, good: bool) -> Secant:
    """Take in the force [N] at the avatar's position [m], where it can be used."""
    if not good:
        position, force = s.position, s.force
    step, rise = minus(position, s.position), minus(force, s.force)
    size, before, now = length(step), s.force != zero(s.force), force != zero(force)
    one_sided = s.one_sided or (not before and not now and size > 0.0)
    longest = DECAY * s.longest
    if before and now:
        longest = max(longest, size)
    slope = s.slope
    if (before or now) and size > max(SHORT * longest, LEAST_M):
        course, secant = scaled(step, 1.0 / size), scaled(rise, 1.0 / size)
        slope = _raised(slope, course, secant, now and not before and one_sided, s.scale)
        if before and now:
            pull = applied(slope, course)
            own, excess = dot(pull, course), dot(minus(pull, secant), course)
            if excess > 0.0 and own > 0.0:
                most = 1.0 if 0.0 < s.longest < SHORT * size else 1.0 - DECAY
                part = scaled(pull, min(most, excess / own))
                slope = each(minus, (slope, outer(part, scaled(pull, 1.0 / own))))
    face_at, face_force = s.face_at, s.face_force
    if now:
        face_at, face_force = position, force
    elif before:
        face_at, face_force = s.position, s.force
    elif s.expected:
        face_at, face_force = zero(force), zero(force)
    return Secant(
        s.scale, position, force, slope, longest, one_sided, face_at, face_force, s.expected
    )


def _raised(slope: Rows, course: Vector, secant: Vector, hits: bool, scale: float) -> Rows:
    pull = applied(slope, course)
    own, missing = dot(course, pull), minus(secant, pull)
    short = dot(missing, course)
    along = course if short < NEARLY_ACROSS * length(missing) else missing
    measured = own + short
    wanted = LEAP * measured if hits and measured > SOFT * scale else measured
    most = min(wanted, LARGEST * scale) - own
    if short <= 0.0 or most <= 0.0:
        return slope
    along = scaled(along, 1.0 / dot(along, course))
    return each(plus, (slope, outer(along, scaled(along, most))))


def _direction(a: Vector) -> Vector:
    size = length(a)
    return scaled(a, 1.0 / size) if size > 0.0 else a


REPAID = 0.3  # of what is undelivered per step
LARGEST_N = 1e6  # more is no force
KICK_M_S = 0.4  # change of force over b


class Seen(NamedTuple):
    """What the port knows of one user."""

    secant: Secant  # with F-, the last force that was used
    visit: int  # of the port
    at: Vector  # [m] where the environment answered last
    there: bool = False
    steps: int = 0  # since F-
    usable: bool = True  # the force that the environment answered in the last step with, if any
    jumped: bool = False


def noted(s: Seen, port: UserPort) -> tuple[Seen, bool, bool, Vector]:
    """Note who is there, and who began anew."""
    there, x, begins = port.avatar.present, port.x_s, port.visit != s.visit
    secant, at, steps = s.secant, s.at, s.steps
    if begins:
        secant, at, steps = resting_secant(x, secant.scale, secant.expected), x, 0
    return Seen(secant, port.visit, at, there, steps, True, False), there, there and begins, x


def guess(s: Seen, port: UserPort, start: Vector, p: Any) -> tuple[Seen, Vector]:
    """Return the velocity decoded with the learned line, or with the last force."""
    a = port.avatar
    if not p.learns:
        return s, wave_velocity(a.impedance, a.u, a.f) if a.present else zero(a.u)
    free = free_velocity(a.impedance, a.u)
    if port.brake.largest[0].left <= 0.0:  # a braked avatar waits
        free = plus(free, scaled(a.kept, REPAID / p.body.period_s))
    velocity, expected = decoded(line(s.secant, start, p.new_s), a.impedance, free)
    return s._replace(secant=s.secant._replace(expected=expected)), velocity


def checked(s: Seen, x: Vector, a: Avatar, way_m: float, learns: bool, h: float) -> Seen:
    """Note a force that cannot be used; learn from another one."""
    f, usable = a.f, within(a.f, LARGEST_N)
    if not learns:
        return s._replace(usable=usable)
    f = f if usable else zero(f)
    scale, steps = s.secant.scale, s.steps + 1
    most = LARGEST * scale * way_m + KICK_M_S * scale * h * steps
    found = length(minus(f, s.secant.force)) <= most
    good = usable and found
    secant = learn(s.secant, x, f, good)
    return Seen(secant, s.visit, x, s.there, 0 if good else steps, usable, usable and not found)
