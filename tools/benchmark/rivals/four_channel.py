# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Four channels (Lawrence 1993) with a passivity observer and controller at each end (Hannaford
and Ryu 2002; Ryu, Artigas and Preusche 2010; for four channels Rebelo and Schiele 2015).

Position, velocity and force go both ways::

    F_m = K (x - x_s) + B (xd - xd_s) + C f_s         f_s = K (x - x_s) + B (xd - xd_s) + C F_m

At rest and without delay F_m = f_s = K (x - x_s)/(1 - C): C -> 1 is Lawrence's transparency. Each
end may give out what the other has taken in, dE more is dissipated by a damper at the device,
a = min(dE/(T |xd|^2), damping_max), and by less drive of the avatar.

Adapted: the hand's force is not measured, so the force of the device stands for it. Both channels
of an end are one port with one observer; Rebelo and Schiele divide them into networks for
position and for force, each with its own. The avatar has no mass: its controller scales the drive
until the step gives out no more than is allowed.

Rebelo and Schiele's paper was not at hand: their division and their gains are not used.
"""

from dataclasses import dataclass

from benchmark.rivals.energy import (
    Damper,
    Observer,
    booked,
    credited,
    damped,
    observed,
    paid_avatar,
    released_j,
)
from pmwvc_core.controllers.plugged import AvatarAnswer, AvatarStep, DeviceAnswer, DeviceTick
from pmwvc_core.controllers.record import HELD, Controller
from pmwvc_core.law.vectors import minus, plus, scaled, zero
from pmwvc_core.params.fields import Validated, parameter

RANGES = {
    "stiffness": (100.0, 3000.0),
    "damping": (1.0, 30.0),
    "forward": (0.05, 0.95),
    "local": (0.3, 20.0),
    "damping_max": (5.0, 100.0),
}


@dataclass(frozen=True)
class Gains(Validated):
    """Channels and passivity controller."""

    stiffness: float = parameter(500.0, "> 0 N/m", "spring between device and avatar, K")
    damping: float = parameter(10.0, ">= 0 N s/m", "damper beside it, B")
    forward: float = parameter(0.5, "0..1", "share of the other end's force fed forward, C")
    local: float = parameter(1.0, ">= 0 N s/m", "local damping of the device")
    damping_max: float = parameter(10.0, ">= 0 N s/m", "most of the passivity controller")


def device(s: Damper, tick: DeviceTick, p: Gains) -> tuple[Damper, DeviceAnswer]:
    """Render spring, damper and force fed forward, dissipate what is not covered."""
    s, force = observed(s, tick), zero(tick.x)
    if tick.packet.number > 0:
        s = s._replace(observer=credited(s.observer, tick.packet.extra[0]))
        if not tick.silent:
            spring = scaled(minus(tick.x, tick.packet.position), p.stiffness)
            damper = scaled(minus(tick.xd, tick.packet.extra[1:]), p.damping)
            force = plus(plus(spring, damper), scaled(tick.packet.wave, p.forward))
    s, total = damped(s, tick, force, p.local, p.damping_max)
    return s, DeviceAnswer(total, tick.xd, (s.observer.in_j, *force))


def avatar(s: Observer, step: AvatarStep, p: Gains) -> tuple[Observer, AvatarAnswer]:
    """Drive the avatar as far as the observer allows."""
    s = credited(s, step.extra[0])
    spring = scaled(minus(step.position, step.x_s), p.stiffness)
    drive = plus(plus(spring, scaled(step.wave, p.damping)), scaled(step.extra[1:], p.forward))
    impedance = p.stiffness * step.period_s + p.damping
    moved = paid_avatar(step, drive, impedance, max(s.allowance_j, 0.0))
    s = booked(s, -released_j(step, moved))
    return s, AvatarAnswer(moved, moved.f, (s.in_j, *moved.xd))


FOUR_CHANNEL_TDPA = Controller(
    name="four_channel_tdpa",
    words="Four channels: what either end would release without cover is dissipated there.",
    waves=False,
    device=device,
    avatar=avatar,
    device_rest=lambda p, axes: Damper(),
    avatar_rest=lambda p, axes: Observer(),
    extra=lambda axes: (1 + axes, 1 + axes),
    params=Gains,
    coupling=HELD,
)
