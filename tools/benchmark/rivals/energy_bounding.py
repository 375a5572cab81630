# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy bounding algorithm (Kim and Ryu, IJRR 2010), here for a force that comes over a link.

The control force may grow only by what was put in and what damping consumes. With the work of the
force held over the last tick, damper included, and a store of stiffness kappa = 2 b/T::

    F^2/(2 kappa) <= F_-^2/(2 kappa) + F_- dx + (b/T) dx^2 + credit

Without credit this is |F| <= |F_- + kappa dx|: a virtual spring up to kappa = 2 b/T, the limit
of a sampled wall with a damper b, passes unchanged, and nothing grows while nothing moves. The
device's port is passive whatever the link does.

Adapted: the simulated device has no damping, so the b whose consumption counts is a damper of the
controller, and its work is counted, not estimated. For a link the bound has a credit: what the
avatar has taken in (a running sum in the packets), without which a hand that is pushed back could
not be held against; and what a tick leaves over is kept up to ``reserve_j`` (the paper keeps
nothing), as the force answers late. The avatar is not bounded, a robot with a supply of its own:
a spring and damper pull it to the device's position.

The paper was not at hand: the bound is derived from its principle, not copied from its equations.
That of Seo, Kim, Kim and Ryu (2011) for a link was not known in detail.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from benchmark.rivals.energy import Place, Received, received, released_j, work_j
from pmwvc_core.controllers.plugged import (
    AvatarAnswer,
    AvatarStep,
    DeviceAnswer,
    DeviceTick,
    pulled_avatar,
)
from pmwvc_core.controllers.record import HELD, Controller
from pmwvc_core.law.vectors import minus, plus, scaled, shortened, squared, zero
from pmwvc_core.params.fields import Validated, parameter

RANGES = {
    "damping": (0.3, 20.0),
    "reserve_j": (1e-4, 0.1),
    "stiffness": (200.0, 5000.0),
    "coupling_damping": (1.0, 30.0),
}


@dataclass(frozen=True)
class Gains(Validated):
    """Both ends."""

    damping: float = parameter(6.0, "> 0 N s/m", "damper whose consumption counts, b")
    reserve_j: float = parameter(5e-3, ">= 0 J", "most that is kept of what a tick leaves over")
    stiffness: float = parameter(800.0, "> 0 N/m", "spring of the avatar to the device")
    coupling_damping: float = parameter(15.0, ">= 0 N s/m", "damper beside it")


class Bound(NamedTuple):
    """The device's end."""

    stored_j: float = 0.0  # F^2/(2 kappa) of the tick before
    reserve_j: float = 0.0
    credit_j: float = 0.0  # of the other end
    came: Received = Received()
    place: Place = Place()


def device(s: Bound, tick: DeviceTick, p: Gains) -> tuple[Bound, DeviceAnswer]:
    """Render as much of the force as is covered, and the damper."""
    place, taken_j = work_j(s.place, tick)
    credit_j, came, force = s.credit_j, s.came, zero(tick.x)
    if tick.packet.number > 0:
        came, gained = received(came, tick.packet.extra[0])
        credit_j += gained
        force = zero(tick.x) if tick.silent else tick.packet.wave
    kappa = 2.0 * p.damping / tick.tick_s
    own_j = s.stored_j + taken_j + s.reserve_j
    force = shortened(force, math.sqrt(2.0 * kappa * max(own_j + credit_j, 0.0)))
    stored_j = squared(force) / (2.0 * kappa)
    left_j = own_j - stored_j  # below zero: paid by the credit
    s = Bound(
        stored_j, min(max(left_j, 0.0), p.reserve_j), credit_j + min(left_j, 0.0), came, place
    )
    return s, DeviceAnswer(plus(force, scaled(tick.xd, p.damping)), tick.xd)


class Taken(NamedTuple):
    """What the avatar has taken in so far [J]."""

    energy_j: float = 0.0


def avatar(s: Taken, step: AvatarStep, p: Gains) -> tuple[Taken, AvatarAnswer]:
    """Pull the avatar to the device; send what it has taken in."""
    spring = scaled(minus(step.position, step.x_s), p.stiffness)
    drive = plus(spring, scaled(step.wave, p.coupling_damping))
    moved = pulled_avatar(step, drive, p.stiffness * step.period_s + p.coupling_damping)
    taken_j = s.energy_j + max(-released_j(step, moved), 0.0)
    return Taken(taken_j), AvatarAnswer(moved, moved.f, (taken_j,))


ENERGY_BOUNDING = Controller(
    name="energy_bounding",
    words="Energy bounding: the device's force grows only by what damping consumes.",
    waves=False,
    device=device,
    avatar=avatar,
    device_rest=lambda p, axes: Bound(),
    avatar_rest=lambda p, axes: Taken(),
    extra=lambda axes: (0, 1),
    params=Gains,
    coupling=HELD,
)
