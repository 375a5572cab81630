# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Input-to-state stable interaction (Jafari and Ryu, ICRA 2015 and J. Franklin Inst. 2016; the
form for two ports is that of public teleoperation software).

The environment is taken for a hysteresis operator whose slope is bounded, 0 <= dF/dx <= mu_max.
A damping that adapts to that slope dissipates less than passivity would ask for::

    device:  F = f + tau (dF/dx) xd        without delay: f + tau df/dt
    avatar:  xd_s = xd - (1/mu_max) df/dt

Integrated, the avatar gives way by f/mu_max, so that at rest K is rendered in series with mu_max:
1/K_felt = 1/K + 1/mu_max. Energy given out is bounded by a constant, not by what was taken in:
passivity is not claimed.

Adapted: the slope is that between the last two packets and the places of the device when they
came, df . dx/|dx|^2, kept within the operator's bound; tau df/dt itself, of a force that is late
or comes in a step, drives the device. The avatar's equation is solved with its contact, about the
position received in place of an integral of velocities, which would drift. The device has local
damping, which theirs have.

The papers were not at hand: how they choose tau and mu_max is not used.
"""

from dataclasses import dataclass
from typing import NamedTuple

from pmwvc_core.controllers.plugged import (
    AvatarAnswer,
    AvatarStep,
    DeviceAnswer,
    DeviceTick,
    pulled_avatar,
)
from pmwvc_core.controllers.record import HELD, Controller
from pmwvc_core.law.vectors import Vector, dot, minus, plus, scaled, squared, zero
from pmwvc_core.params.fields import Validated, parameter

LEAST_M2 = 1e-16  # a shorter way has no slope: the one before counts
RANGES = {"tau_s": (1e-3, 0.1), "slope_max": (100.0, 5000.0), "local": (0.3, 20.0)}


@dataclass(frozen=True)
class Gains(Validated):
    """Both ends."""

    tau_s: float = parameter(0.03, ">= 0 s", "time of the device's adapting damping, tau")
    slope_max: float = parameter(850.0, "> 0 N/m", "bound of the environment's slope, mu_max")
    local: float = parameter(6.0, ">= 0 N s/m", "local damping of the device")


class Seen(NamedTuple):
    """The force received last, where the device was then, and the slope."""

    force: Vector = ()
    x: Vector = ()
    slope: float = 0.0  # [N/m]
    number: int = 0


def seen(s: Seen, tick: DeviceTick, p: Gains) -> Seen:
    """Take in a packet."""
    packet, slope = tick.packet, s.slope
    if tick.silent or not s.force:
        return Seen(zero(tick.x) if tick.silent else packet.wave, tick.x, 0.0, packet.number)
    if packet.number == s.number:
        return s
    way = minus(tick.x, s.x)
    if squared(way) > LEAST_M2:
        slope = dot(minus(packet.wave, s.force), way) / squared(way)
    return Seen(packet.wave, tick.x, min(max(slope, 0.0), p.slope_max), packet.number)


def device(s: Seen, tick: DeviceTick, p: Gains) -> tuple[Seen, DeviceAnswer]:
    """Render the force received, and damping by its slope beside the local one."""
    damping = p.local
    if tick.packet.number > 0:
        s = seen(s, tick, p)
        damping += p.tau_s * s.slope
    force = scaled(tick.xd, damping)
    return s, DeviceAnswer(plus(force, s.force) if s.force else force, tick.xd)


def avatar(s: tuple[()], step: AvatarStep, p: Gains) -> tuple[tuple[()], AvatarAnswer]:
    """Give way by f/mu_max behind the device."""
    drive = scaled(minus(step.position, step.x_s), p.slope_max)
    moved = pulled_avatar(step, drive, p.slope_max * step.period_s)
    return s, AvatarAnswer(moved, moved.f)


ISS_DAMPING = Controller(
    name="iss_damping",
    words="Input-to-state stable: damping that adapts to the slope of the force; not passive.",
    waves=False,
    device=device,
    avatar=avatar,
    device_rest=lambda p, axes: Seen(),
    avatar_rest=lambda p, axes: (),
    params=Gains,
    coupling=HELD,
)
