# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Passive set-position modulation (Lee and Huang 2010): device and avatar hang on set points that
follow each other as far as energy allows.

::

    F_m = B xd_m + K (x_m - q_m),    f_s = K (q_s - x_s) - B xd_s

q follows the other end as received (``aimed``). With x where an end is, moving q to q' costs

    dE = K/2 (|x - q'|^2 - |x - q|^2)

out of a tank; q' is the nearest point on the way that the tank can pay for. The tank gets what the
damper turns to heat, and what the peer sends; above a cap the rest goes to the peer::

    work put in + received = spring + (tank - initial) + sent + dropped
"""

import math
from typing import NamedTuple

from pmwvc_core.law.channel.packet import Sent
from pmwvc_core.law.family import accounts
from pmwvc_core.law.safety.brakes import released_brake
from pmwvc_core.law.vectors import Vector, dot, minus, plus, scaled, squared, zero
from pmwvc_core.law.without_waves import ends
from pmwvc_core.law.without_waves.ends import AvatarAnswer, DeviceEndParams, pulled_avatar


class Pspm(NamedTuple):
    """The law at either end: K [N/m], B [N s/m], cap [J]."""

    stiffness: float
    damping: float
    cap_j: float


class ModulatedSpring(NamedTuple):
    """Set point, tank and sums of an end."""

    q: Vector  # [m] set point
    tank_j: float
    placed: bool = False  # at this end, since it joined; at the device: while answers come
    spring_j: float = 0.0
    sent_j: float = 0.0  # running sum, goes into the packets
    received_j: float = 0.0
    dropped_j: float = 0.0  # springs let go


def taken_in(s: ModulatedSpring, received_j: float) -> ModulatedSpring:
    """Take in what the peer has sent so far."""
    tank_j = s.tank_j + (received_j - s.received_j)
    return s._replace(tank_j=tank_j, received_j=received_j)


def set_to(s: ModulatedSpring, q: Vector, x: Vector, work_j: float, p: Pspm) -> ModulatedSpring:
    """Note that this end is at x and its set point at q [m], with this work put in at its port."""
    spring_j = 0.5 * p.stiffness * squared(minus(x, q))
    tank_j = s.tank_j + work_j - (spring_j - s.spring_j)
    return s._replace(q=q, tank_j=tank_j, spring_j=spring_j)


def aimed(s: ModulatedSpring, wanted: Vector, x: Vector, p: Pspm) -> ModulatedSpring:
    """Move the set point towards a wanted one [m], as far as the tank allows: the ratio s of the
    way w costs K/2 (s^2 |w|^2 - 2 s w . (x - q)).
    """
    way = minus(wanted, s.q)
    size, along = squared(way), dot(way, minus(x, s.q))
    if size == 0.0:
        return set_to(s, s.q, x, 0.0, p)
    root = math.sqrt(max(along * along + 2.0 * size * s.tank_j / p.stiffness, 0.0))
    ratio = min(max((along + root) / size, 0.0), 1.0)
    return set_to(s, plus(s.q, scaled(way, ratio)), x, 0.0, p)


def divided(s: ModulatedSpring, p: Pspm) -> ModulatedSpring:
    """Send the peer what is above the cap."""
    excess_j = max(s.tank_j - p.cap_j, 0.0)
    return s._replace(tank_j=s.tank_j - excess_j, sent_j=s.sent_j + excess_j)


def spring_let_go(s: ModulatedSpring, x: Vector) -> ModulatedSpring:
    """Put the set point where this end is; what the spring holds is dropped."""
    return s._replace(q=x, placed=True, spring_j=0.0, dropped_j=s.dropped_j + s.spring_j)


@ends.device_moved.member(ModulatedSpring)
def _moved(
    s: ModulatedSpring, was: ends.DeviceEnd, x: Vector, xd: Vector, p: DeviceEndParams
) -> ModulatedSpring:
    """Count the work that the force applied last has done until here."""
    return set_to(s, s.q if s.placed else x, x, dot(was.f, minus(x, was.x)), p.law)


@ends.device_sends.member(ModulatedSpring)
def _send(
    s: ModulatedSpring, end: ends.DeviceEnd, frame_s: float, p: DeviceEndParams
) -> tuple[ModulatedSpring, Sent]:
    s = divided(s, p.law)
    return s, Sent(end.xd, end.x, s.sent_j, (), 0)


@ends.device_answer.member(ModulatedSpring)
def _aim(
    s: ModulatedSpring, end: ends.DeviceEnd, came: ends.FromServer, p: DeviceEndParams
) -> ModulatedSpring:
    s = taken_in(s, came.received_j)
    s = spring_let_go(s, end.x) if came.silent else aimed(s, came.wave, end.x, p.law)
    return s._replace(placed=not came.silent)


@ends.device_force.member(ModulatedSpring)
def _force(
    s: ModulatedSpring, end: ends.DeviceEnd, p: DeviceEndParams
) -> tuple[ModulatedSpring, Vector]:
    pull = scaled(minus(end.x, s.q), p.law.stiffness)
    return s, plus(scaled(end.xd, p.law.damping), pull) if s.placed else zero(end.x)


@accounts.member(ModulatedSpring)
def _of_spring(s: ModulatedSpring, p: Pspm) -> Vector:
    return (s.tank_j, s.spring_j)


@released_brake.member(ModulatedSpring)
def _released(s: ModulatedSpring) -> ModulatedSpring:
    """Have the set point placed when the user joins again."""
    return s._replace(placed=False)


@ends.avatar_moved.member(Pspm)
def _pulled(
    p: Pspm, kept: ModulatedSpring, step: ends.AvatarStep
) -> tuple[ModulatedSpring, AvatarAnswer]:
    """Move the set point, then the avatar; one that has just joined begins where it is."""
    spring = kept if kept.placed else spring_let_go(kept, step.x_s)
    spring = aimed(taken_in(spring, step.received_j), step.position, step.x_s, p)
    drive = scaled(minus(spring.q, step.x_s), p.stiffness)
    moved = pulled_avatar(step, drive, p.stiffness * step.period_s + p.damping)
    work_j = -step.period_s * dot(moved.f, moved.xd)
    spring = divided(set_to(spring, spring.q, moved.x_s, work_j, p), p)
    return spring, AvatarAnswer(moved, minus(moved.x_s, step.offset), (), spring.sent_j)
