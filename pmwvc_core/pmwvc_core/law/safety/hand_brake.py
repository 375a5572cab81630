# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The brake at the device: it holds the hand where it was while no waves come.

An elastic-plastic spring z beside the damper b, which gives what is missing of a force F_L
(:mod:`.brake_force`)::

    z <- z + dx,   F = k z,   k = b/STALL_S
    z shortened to |k z| <= F_L, |f + k z| <= max(F_L, |f|)      f: asked for without it

z begins at zero and is only ever shortened, so sum F dx + k |dx|^2/2 >= k |z|^2/2: what sampling
generates is less than the damper takes while k T <= 2 b (loops that stall up to 2 ``STALL_S``).

Equations: docs/theory.md 17.12.
"""

from typing import NamedTuple

from pmwvc_core.law.channel.affordable import affordable
from pmwvc_core.law.safety.brake_force import BrakeForce, brake_force, brake_limit, resting_brake
from pmwvc_core.law.vectors import Vector, minus, plus, scaled, shortened, squared, within, zero

STALL_S = 0.0125
RETURN_S = 0.2
LARGEST_M = 1e100  # a position beyond it is none


class HandBrake(NamedTuple):
    """Its largest force, the position before, and the deflection z [m]."""

    largest: BrakeForce
    x: Vector
    z: Vector


def resting_hand_brake(nothing: Vector) -> HandBrake:
    """Return a brake that holds nothing."""
    return HandBrake(resting_brake(nothing), nothing, nothing)


def brake_stiffness(impedance: float) -> float:
    """Return k [N/m] for a wave impedance, the smallest one of a matrix [N s/m]."""
    return impedance * (1.0 / STALL_S)


def brake_stored_j(s: HandBrake, k: float) -> float:
    """Return the energy that the hand can have back [J]."""
    return 0.5 * k * squared(s.z)


def holding(
    s: HandBrake, waits: bool, x: Vector, f: Vector, tick_s: float, k: float
) -> tuple[HandBrake, bool]:
    """Go one tick on; tell whether anything is held.

    Whether no waves come; the position [m]: where it is no number nothing begins to be held; and
    the force on the device in the tick before [N].
    """
    known = within(x, LARGEST_M)
    largest = brake_force(s.largest, waits and known, f, tick_s, RETURN_S)
    if largest.left <= 0.0:
        return HandBrake(largest, x, zero(s.z)), False
    moved = x if known else zero(x)
    moved = minus(moved, s.x) if within(s.x, LARGEST_M) else moved
    z = shortened(plus(s.z, moved), brake_limit(largest) / k)
    return HandBrake(largest, x, z), True


def brake_push(s: HandBrake, f: Vector, k: float) -> tuple[HandBrake, Vector]:
    """Return the brake's force beside a force that the controller asks for [N]."""
    limit = brake_limit(s.largest)
    given, _ = affordable(f, scaled(s.z, k), max(limit * limit - squared(f), 0.0))
    return s._replace(z=scaled(given, 1.0 / k)), given
