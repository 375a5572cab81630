# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the rivals share: sums of energy in packets, the work of the last tick, an observer with
its two controllers, and an avatar that may release only so much.

Both ends send running sums [J], so that a lost packet loses no energy and a repeated one makes
none. The first sum of a sender only sets the reference: what it counted before is not credited.
"""

from typing import NamedTuple

from pmwvc_core.controllers.plugged import AvatarStep, DeviceTick, Moved, pulled_avatar
from pmwvc_core.law.vectors import Vector, dot, minus, scaled, squared, zero

HALVINGS = 20
LEAST = 1e-30  # a square below it is nothing to divide by


class Received(NamedTuple):
    """The running sum of the other end as last seen [J]."""

    sum_j: float = 0.0
    begun: bool = False


def received(s: Received, sum_j: float) -> tuple[Received, float]:
    """Return what came since the last sum; a sum that fell is that of another life."""
    gained = max(sum_j - s.sum_j, 0.0) if s.begun else 0.0
    return Received(sum_j, True), gained


class Place(NamedTuple):
    """Where a device was at its last tick [m]."""

    x: Vector = ()


def work_j(s: Place, tick: DeviceTick) -> tuple[Place, float]:
    """Return the work that the hand put in since the last tick: the force held, as applied, times
    the way [J].
    """
    done = dot(tick.applied, minus(tick.x, s.x)) if s.x else 0.0
    return Place(tick.x), done


class Observer(NamedTuple):
    """Passivity observer of one end (Ryu, Artigas and Preusche 2010) [J]: sum taken in here, and
    what may still be given out.
    """

    in_j: float = 0.0
    allowance_j: float = 0.0
    came: Received = Received()


def credited(s: Observer, sum_j: float) -> Observer:
    """Take over what the other end has taken in."""
    came, gained = received(s.came, sum_j)
    return s._replace(allowance_j=s.allowance_j + gained, came=came)


def booked(s: Observer, taken_j: float) -> Observer:
    """Book what came in here (negative: was given out)."""
    given_j = max(-taken_j, 0.0)
    return s._replace(in_j=s.in_j + max(taken_j, 0.0), allowance_j=s.allowance_j - given_j)


class Damper(NamedTuple):
    """A device's end with its passivity controller."""

    place: Place = Place()
    observer: Observer = Observer()
    passive: float = 0.0  # [N s/m] controller's damper, and of it and the local one together
    both: float = 0.0
    xd: Vector = ()


def observed(s: Damper, tick: DeviceTick) -> Damper:
    """Book the last tick: work of the force without both dampers, whose heat is not the link's;
    that of the controller's is allowance again.
    """
    place, taken_j = work_j(s.place, tick)
    drag = dot(s.xd, minus(tick.x, s.place.x)) if s.place.x and s.xd else 0.0
    observer = booked(s.observer, taken_j - s.both * drag)
    allowance_j = observer.allowance_j + s.passive * drag
    return s._replace(place=place, observer=observer._replace(allowance_j=allowance_j))


def damped(
    s: Damper, tick: DeviceTick, force: Vector, local: float, most: float
) -> tuple[Damper, Vector]:
    """Add the controller's damper, a = min(dE/(T |xd|^2), most), where the next tick would give
    out dE too much, and the local damper.
    """
    size, passive = squared(tick.xd), 0.0
    if size > LEAST:
        out_j = max(-tick.tick_s * dot(force, tick.xd), 0.0)
        excess_j = max(out_j - s.observer.allowance_j, 0.0)
        passive = min(excess_j / (tick.tick_s * size), most)
    both = passive + local
    s = s._replace(passive=passive, both=both, xd=tick.xd)
    return s, tuple(f + both * v for f, v in zip(force, tick.xd, strict=True))


def paid_avatar(step: AvatarStep, drive: Vector, impedance: float, most_j: float) -> Moved:
    """Let an avatar be pulled by as much of a drive [N] as a store can pay for.

    It releases E(s) = h f . xd_s with s times the drive, at most ``most_j``; without drive it is
    a damper.
    """
    whole = pulled_avatar(step, drive, impedance)
    if released_j(step, whole) <= most_j:
        return whole
    low, high = 0.0, 1.0
    best = pulled_avatar(step, zero(drive), impedance)
    for _ in range(HALVINGS):
        ratio = 0.5 * (low + high)
        moved = pulled_avatar(step, scaled(drive, ratio), impedance)
        if released_j(step, moved) <= most_j:
            low, best = ratio, moved
        else:
            high = ratio
    return best


def released_j(step: AvatarStep, moved: Moved) -> float:
    """Return the energy that an avatar gives to the object in a step [J]."""
    return step.period_s * dot(moved.f, moved.xd)
