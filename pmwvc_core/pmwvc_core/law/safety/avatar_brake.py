# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The brake at an avatar: it holds the contact while no waves of its user come.

A damper (N - 1) b beside the port. The coupling then solves a port of impedance N b, and the waves
of the user are those in front of the damper::

    u' = u/sqrt(N),   v = (u' + v')/sqrt(N) - u
    (|u|^2 - |v|^2)/2 = (|u'|^2 - |v'|^2)/2 + (N - 1)/(2 N) |u' + v'|^2

The last term is heat, for any N >= 1. N gives a friction of at most F_L (:mod:`.brake_force`)
against the contact's force R that the wave leaves over::

    R = f_s - sqrt(2b) u,   N = |R|/(|R| - F_L), at most ``FIRMEST``; 1 where R . f_s <= 0

Equations: docs/theory.md 17.13.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.family import Family, same
from pmwvc_core.law.safety.brake_force import BrakeForce, brake_force, brake_limit, resting_brake
from pmwvc_core.law.vectors import Vector, dot, each, length, minus, scaled, squared
from pmwvc_core.law.wave.wave import Impedance, MatrixImpedance, damper, free_velocity, impedance

FIRMEST = 1000.0  # 1.6 N move the avatar behind 25 N s/m with less than 0.1 mm/s
RETURN_S = 0.1


class AvatarBrake(NamedTuple):
    """Its largest force, and its heat since the start [J]."""

    largest: BrakeForce
    heat_j: float


firmer = Family("firmer")  # (impedance, n) -> n times an impedance


@firmer.member(Impedance)
def _firmer(p: Impedance, n: float) -> Impedance:
    return impedance(n * p.b)


@firmer.member(MatrixImpedance)
def _firmer_matrix(p: MatrixImpedance, n: float) -> MatrixImpedance:
    root = math.sqrt(n)
    return MatrixImpedance(
        each(scaled, (p.b,), n), each(scaled, (p.inverse,), 1.0 / n),
        each(scaled, (p.root_2b,), root), each(scaled, (p.root_2_over_b,), 1.0 / root),
        p.numbers, scaled(p.values, n), p.to_axes, p.from_axes,
    )  # fmt: skip


# (s) -> s: the user left; also of what a controller without waves keeps of an avatar
released_brake = Family("released_brake", same)


@released_brake.member(AvatarBrake)
def _released(s: AvatarBrake) -> AvatarBrake:
    """Let go at once; what became heat stays counted."""
    return AvatarBrake(resting_brake(s.largest.mean), s.heat_j)


def brake_ratio(
    s: AvatarBrake, b: Any, u: Vector, f_s: Vector, waits: bool, h: float
) -> tuple[AvatarBrake, float]:
    """Return N for a step of h [s], from the wave received [sqrt(W)] and the contact force of the
    last step [N]; 1 where nothing brakes.
    """
    largest = brake_force(s.largest, waits, f_s, h, RETURN_S)
    limit, ratio = brake_limit(largest), 1.0
    if limit > 0.0:
        left = minus(f_s, damper(b, free_velocity(b, u)))
        if dot(left, f_s) > 0.0:
            size = length(left)
            ratio = size / max(size - limit, size * (1.0 / FIRMEST))
    return AvatarBrake(largest, s.heat_j), ratio


def braked(b: Any, u: Vector, ratio: float) -> tuple[Any, Vector]:
    """Return impedance and wave behind the damper."""
    return firmer(b, ratio), scaled(u, 1.0 / math.sqrt(ratio))


def unbraked(
    s: AvatarBrake, b: Any, u: Vector, both: Vector, ratio: float, h: float
) -> tuple[AvatarBrake, Any, Vector]:
    """Return the impedance of the port itself and the wave in front of the damper [sqrt(W)], given
    the wave received and u' + v'.
    """
    heat_j = s.heat_j + (1.0 - 1.0 / ratio) * (0.5 * h) * squared(both)
    wave = minus(scaled(both, 1.0 / math.sqrt(ratio)), u)
    return AvatarBrake(s.largest, heat_j), firmer(b, 1.0 / ratio), wave
