# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The brakes, which hold on while no waves come: the hand where it was, and the avatar's contact.

The largest force F_L of either is ``RATIO`` times the mean force over ``MEAN_S`` before the wait.
It grows over ``FADE_S``, stays while the end waits, and fades over ``return_s`` afterwards.

At the device an elastic-plastic spring z beside the damper b gives what is missing of F_L::

    z <- z + dx,   F = k z,   k = b/STALL_S
    z shortened to |k z| <= F_L, |f + k z| <= max(F_L, |f|)      f: asked for without it

At the avatar a damper (N - 1) b beside the port, which the coupling solves with the impedance N b;
the last term is heat. Force and torque of six axes have one each, of their own N::

    u' = u/sqrt(N),   v = (u' + v')/sqrt(N) - u
    (|u|^2 - |v|^2)/2 = (|u'|^2 - |v'|^2)/2 + (N - 1)/(2 N) |u' + v'|^2

N >= 1 gives a friction of at most F_L against the contact's force R that the wave leaves over::

    R = f_s - sqrt(2b) u,   N = |R|/(|R| - F_L), at most ``FIRMEST``; 1 where R . f_s <= 0

Equations: docs/theory.md 17.12, 17.13, 17.15.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.constants import FADE_S, RATIO, SETTLE_S
from pmwvc_core.law.family import Family, same
from pmwvc_core.law.vectors import (
    Vector,
    between,
    columns,
    dot,
    each,
    inverse,
    length,
    measured,
    minus,
    plus,
    scaled,
    shortened,
    squared,
    times,
    zero,
)
from pmwvc_core.law.wave.wave import Rows, affordable, damper, firmer, free_velocity

MEAN_S, HAND_RETURN_S = 0.5 * SETTLE_S, 2.0 * SETTLE_S
FIRMEST = 1000.0  # 1.6 N move the avatar behind 25 N s/m with less than 0.1 mm/s


class BrakeForce(NamedTuple):
    """Mean force rendered [N], the largest one in a wait [N], and what ratio of that acts."""

    mean: Vector
    held: float
    left: float


def resting_brake(like: Vector) -> BrakeForce:
    """Return the brake of an end that renders no force."""
    return BrakeForce(zero(like), 0.0, 0.0)


def brake_limit(s: BrakeForce) -> float:
    """Return the largest force of the present step [N]; zero where nothing is held."""
    return s.held * s.left


def brake_force(s: BrakeForce, waits: bool, f: Vector, h: float, return_s: float) -> BrakeForce:
    """Go one step of h [s] on: whether no waves come; the force rendered in the last one [N]."""
    mean, held = s.mean, s.held
    if s.left <= 0.0:
        mean = between(mean, f, min(h / MEAN_S, 1.0))
        if not waits:
            return BrakeForce(mean, held, 0.0)
        held = RATIO * length(mean)
    change = h / FADE_S if waits else -h / return_s
    return BrakeForce(mean, held, min(max(s.left + change, 0.0), 1.0))


class HandBrake(NamedTuple):
    """Its largest force, and the deflection z [m]."""

    largest: BrakeForce
    z: Vector


def loose_brake(nothing: Vector) -> HandBrake:
    """Return a brake that holds nothing."""
    return HandBrake(resting_brake(nothing), nothing)


def brake_stored_j(s: HandBrake, k: float) -> float:
    """Return the energy that the hand can have back [J]."""
    return 0.5 * k * squared(s.z)


def hand_braked(
    s: HandBrake, waits: bool, way: Vector, last: Vector, f: Vector, tick_s: float, k: float
) -> tuple[HandBrake, Vector]:
    """Go one tick and a way on; return the brake's force beside one that the controller asks for.
    ``last`` is the force on the device in the tick before [N]; where the way [m] is no number
    nothing begins to be held.
    """
    known = measured(way)
    largest = brake_force(s.largest, waits and known, last, tick_s, HAND_RETURN_S)
    if largest.left <= 0.0:
        return HandBrake(largest, zero(s.z)), zero(s.z)
    limit = brake_limit(largest)
    z = shortened(plus(s.z, way if known else zero(way)), limit / k)
    given, _ = affordable(f, scaled(z, k), max(limit * limit - squared(f), 0.0))
    return HandBrake(largest, scaled(given, 1.0 / k)), given


class AvatarBrake(NamedTuple):
    """Largest force of each brake, N of each axis, and the heat since the start [J]."""

    largest: tuple[BrakeForce, ...]  # growing and fading together
    n: Vector
    heat_j: float


# (s) -> s: the user left; also of what a controller without waves keeps of an avatar
released_brake = Family("released_brake", same)


@released_brake.member(AvatarBrake)
def _released(s: AvatarBrake) -> AvatarBrake:
    """Let go at once; what became heat stays counted."""
    means, _, _ = columns(s.largest)
    return s._replace(largest=each(resting_brake, (means,)))


def braked(
    s: AvatarBrake, b: Any, u: Vector, f_s: Vector, waits: bool, h: float, brakes: Rows
) -> tuple[AvatarBrake, Any, Vector]:
    """Go a step of h [s] on; return impedance and wave behind the damper."""
    largest, own = columns(each(_held, (s.largest, brakes), b, u, f_s, waits, h))
    n = own[0]
    for i in range(1, len(own)):
        n = plus(n, own[i])
    s = AvatarBrake(largest, n, s.heat_j)
    if max(n) <= 1.0:
        return s, b, u
    return s, firmer(b, n), times(u, inverse(each(math.sqrt, (n,))))


def _held(
    s: BrakeForce, axes: Vector, b: Any, u: Vector, f_s: Vector, waits: bool, h: float
) -> tuple[BrakeForce, Vector]:
    f = times(f_s, axes)
    largest = brake_force(s, waits, f, h, SETTLE_S)
    limit, ratio = brake_limit(largest), 1.0
    if limit > 0.0:
        left = times(minus(f_s, damper(b, free_velocity(b, u))), axes)
        if dot(left, f) > 0.0:
            size = length(left)
            ratio = size / max(size - limit, size * (1.0 / FIRMEST))
    return largest, scaled(axes, ratio)


def unbraked(
    s: AvatarBrake, b: Any, u: Vector, inner: Vector, v: Vector, h: float, brakes: Rows
) -> tuple[AvatarBrake, Any, Vector]:
    """Return impedance and wave in front of the damper, given u, and u' and v' behind it."""
    if max(s.n) <= 1.0:
        return s, b, v
    both, heat_j = plus(inner, v), s.heat_j
    for i in range(len(brakes)):
        ratio, moved = max(times(s.n, brakes[i])), times(both, brakes[i])
        heat_j += (1.0 - 1.0 / ratio) * (0.5 * h) * squared(moved)
    wave = minus(times(both, inverse(each(math.sqrt, (s.n,)))), u)
    return s._replace(heat_j=heat_j), firmer(b, inverse(s.n)), wave
