# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Input-to-state stable interaction (Jafari and Ryu, ICRA 2015 and J. Franklin Inst. 2016; the
form for two ports is that of public teleoperation software).

The environment is taken for a hysteresis operator whose slope is bounded, 0 <= dF/dx <= mu_max.
A damping that adapts to that slope releases less than passivity would ask for::

    device:  F = f + tau df/dt            df/dt = (dF/dx) xd: a damping tau dF/dx
    avatar:  xd_s = xd - (1/mu_max) df/dt

Integrated, the avatar gives way by f/mu_max, so that at rest K is rendered in series with mu_max:
1/K_felt = 1/K + 1/mu_max. Energy given out is bounded by a constant, not by what was taken in:
passivity is not claimed.

Adapted: the avatar's equation is solved with its contact, about the position received in place of
an integral of velocities, which would drift. df/dt is the change between the last two packets,
over their distance, kept within mu_max |xd|: the bound of the operator, which a force that
arrives late or in a step would break. The device has local damping, which theirs have.

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
from pmwvc_core.law.vectors import Vector, length, minus, plus, scaled, shortened, zero
from pmwvc_core.params.fields import Validated, parameter

RANGES = {"tau_s": (1e-3, 0.2), "slope_max": (100.0, 5000.0), "local": (0.3, 20.0)}


@dataclass(frozen=True)
class Gains(Validated):
    """Both ends."""

    tau_s: float = parameter(0.03, ">= 0 s", "time of the device's adapting damping, tau")
    slope_max: float = parameter(850.0, "> 0 N/m", "bound of the environment's slope, mu_max")
    local: float = parameter(5.0, ">= 0 N s/m", "local damping of the device")


class Slope(NamedTuple):
    """The force received last and how fast it changed."""

    force: Vector = ()
    rate: Vector = ()  # [N/s]
    number: int = 0


def changed(s: Slope, tick: DeviceTick) -> Slope:
    """Take in a packet."""
    packet, zeros = tick.packet, zero(tick.x)
    passed = packet.number - s.number
    if not s.force or tick.silent or passed < 0:
        return Slope(zeros if tick.silent else packet.wave, zeros, packet.number)
    if passed == 0:
        return s
    rate = scaled(minus(packet.wave, s.force), 1.0 / (passed * packet.period_s))
    return Slope(packet.wave, rate, packet.number)


def device(s: Slope, tick: DeviceTick, p: Gains) -> tuple[Slope, DeviceAnswer]:
    """F = f + tau df/dt, with local damping."""
    force = scaled(tick.xd, p.local)
    if tick.packet.number > 0:
        s = changed(s, tick)
        rate = shortened(s.rate, p.slope_max * length(tick.xd))
        force = plus(force, plus(s.force, scaled(rate, p.tau_s)))
    return s, DeviceAnswer(force, tick.xd)


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
    device_rest=lambda p, axes: Slope(),
    avatar_rest=lambda p, axes: (),
    params=Gains,
    coupling=HELD,
)
