# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the port of a black box knows of one user: where its avatar was left, the slope
learned there, and whether the environment's force could be used.

An avatar that is not where the last step left it, with that force, began anew.

A force that jumps while hardly anything moved is a fault of the environment. With s the longest
way in this step of any avatar or of the object (fading over ``MEMORY_S``), a change of force since
the last one that was used, n steps ago, is accepted up to

    |F - F-| <= 100 (b/T) s + b n ``KICK_M_S``

The first term is the stiffest contact that the port can learn (``secant.LARGEST``); by the second
a force that stays is accepted soon.

Equations: docs/theory.md 5.13.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.black_box.secant import (
    LARGEST,
    Secant,
    decoded,
    learn,
    line,
    resting_secant,
)
from pmwvc_core.law.server.server_port import UserPort
from pmwvc_core.law.vectors import Vector, is_zero, length, minus, plus, scaled, within, zero
from pmwvc_core.law.wave.wave import free_velocity, wave_velocity

REPAID = 0.3  # of what is undelivered per step
LARGEST_N = 1e6  # more is no force
KICK_M_S = 0.4  # change of force over b
MEMORY_S = 0.5


class Seen(NamedTuple):
    """What the port knows of one user."""

    there: bool
    x: Vector  # of the avatar at the end of the last step: another one means that it began anew
    f: Vector
    secant: Secant  # with F-, the last force that was used
    at: Vector  # [m] where the environment answered last
    steps: int  # since F-
    usable: bool  # the force that the environment answered in the last step with, if it did
    jumped: bool


def faded(way_m: float, period_s: float) -> float:
    """Return what is left of the longest way after a step [m]."""
    return max(1.0 - period_s / MEMORY_S, 0.0) * way_m


def resting_seen(position: Vector, scale: float) -> Seen:
    """Return a user who is not there; ``scale`` is b/T with the smallest impedance [N/m]."""
    secant = resting_secant(position, scale, False)
    return Seen(False, position, zero(position), secant, position, 0, True, False)


def noted(s: Seen, port: UserPort) -> tuple[Seen, bool, bool, Vector]:
    """Note who is there, and who began anew: where the last step did not leave the avatar."""
    there, x, f = port.avatar.present, port.x_s, port.avatar.f
    stayed = s.there and is_zero(minus(x, s.x)) and is_zero(minus(f, s.f))
    begins, secant, at, steps = there and not stayed, s.secant, s.at, s.steps
    if begins:
        secant, at, steps = resting_secant(x, secant.scale, secant.expected), x, 0
    return Seen(there, x, f, secant, at, steps, True, False), there, begins, x


def guess(s: Seen, port: UserPort, start: Vector, p: Any) -> tuple[Seen, Vector]:
    """Return the velocity decoded with the learned line, or with the last force."""
    a = port.avatar
    if not p.learns:
        return s, wave_velocity(a.impedance, a.u, a.f) if a.present else zero(a.u)
    free = free_velocity(a.impedance, a.u)
    if port.brake.largest.left <= 0.0:  # a braked avatar waits
        free = plus(free, scaled(a.kept, REPAID / p.body.period_s))
    velocity, expected = decoded(line(s.secant, start, p.new_s), a.impedance, free)
    return s._replace(secant=s.secant._replace(expected=expected)), velocity


def checked(s: Seen, position: Vector, force: Vector, way_m: float, p: Any) -> Seen:
    """Note a force that cannot be used; learn from another one."""
    usable = within(force, LARGEST_N)
    if not p.learns:
        return s._replace(usable=usable)
    if not usable:
        force = zero(force)
    scale, steps = s.secant.scale, s.steps + 1
    most = LARGEST * scale * way_m + KICK_M_S * scale * p.body.period_s * steps
    found = length(minus(force, s.secant.force)) <= most
    good = usable and found
    secant = learn(s.secant, position, force, good)
    steps = 0 if good else steps
    return Seen(s.there, s.x, s.f, secant, position, steps, usable, usable and not found)
