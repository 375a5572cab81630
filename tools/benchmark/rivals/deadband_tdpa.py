# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Perceptual deadband with time-domain passivity control, as in the haptic codec of IEEE 1918.1.1
(deadband: Hinterseer, Hirche, Chaudhuri, Steinbach and Buss 2008; with observers: Xu, Cizmeci,
Schuwerk and Steinbach 2016).

The device's velocity and the avatar's force are updated outside a Weber deadband only, and held::

    |s - s_sent| > k |s_sent|    ->    s_sent = s
    allowance = E_in of the other, as received - E_out + dissipated
    device:  F = f_sent + a xd,    a = min(dE/(T |xd|^2), damping_max)
    avatar:  xd_s = xd_sent - dE/(h |f|^2) f

Adapted: packets leave in every frame, as for all methods, and repeat what was updated last, so
the deadband costs its error and saves nothing here. The sums of energy go with every packet: sent
with updates only, an avatar in even motion would have to stop. An update of the velocity also has
the device's position, from where the held velocity goes on; ``drift_share`` of the avatar's lag
behind that is made up in a step, if energy allows (after Coelho et al. 2019). What is below 0.5
mm/s or 5 mN counts as zero, and going to zero is an update. The device has local damping.

The standard was not at hand: its bit streams and entropy coding are left out.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

from benchmark.rivals.energy import LEAST, Damper, Observer, booked, credited, damped, observed
from pmwvc_core.controllers.plugged import (
    AvatarAnswer,
    AvatarStep,
    DeviceAnswer,
    DeviceTick,
    placed_avatar,
)
from pmwvc_core.controllers.record import HELD, Controller
from pmwvc_core.law.vectors import Vector, dot, length, minus, plus, scaled, squared, zero
from pmwvc_core.params.fields import Validated, parameter

LEAST_M_S, LEAST_N = 5e-4, 5e-3  # signals below it are at rest
RANGES = {
    "deadband": (0.01, 0.3),
    "local": (0.3, 20.0),
    "damping_max": (5.0, 100.0),
    "drift_share": (0.01, 0.5),
}


@dataclass(frozen=True)
class Gains(Validated):
    """Deadband and passivity controllers."""

    deadband: float = parameter(0.05, "0..1", "ratio of change that is not felt, k")
    local: float = parameter(9.0, ">= 0 N s/m", "local damping of the device")
    damping_max: float = parameter(25.0, ">= 0 N s/m", "most of the device's controller")
    drift_share: float = parameter(0.1, "0..1", "share of its lag that an avatar makes up a step")


class Update(NamedTuple):
    """The sample sent last: signal and position; empty before the first."""

    signal: Vector = ()
    x: Vector = ()


def updated(s: Update, signal: Vector, x: Vector, k: float, least: float) -> Update:
    """Return what the other end has from now on."""
    signal = signal if length(signal) > least else zero(signal)
    if s.signal and squared(minus(signal, s.signal)) <= k * k * squared(s.signal):
        return s
    return Update(signal, x)


class DeviceEnd(NamedTuple):
    """The device's end."""

    damper: Damper = Damper()
    sent: Update = Update()


class AvatarEnd(NamedTuple):
    """The avatar's end, with the device's position as updated and as held velocity goes on."""

    observer: Observer = Observer()
    sent: Update = Update()
    came: Vector = ()
    aim: Vector = ()


def device(s: DeviceEnd, tick: DeviceTick, p: Gains) -> tuple[DeviceEnd, DeviceAnswer]:
    """Render the force held, dissipate what is not covered."""
    damper, force = observed(s.damper, tick), zero(tick.x)
    if tick.packet.number > 0:
        damper = damper._replace(observer=credited(damper.observer, tick.packet.extra[0]))
        force = zero(tick.x) if tick.silent else tick.packet.wave
    damper, total = damped(damper, tick, force, p.local, p.damping_max)
    sent = updated(s.sent, tick.xd, tick.x, p.deadband, LEAST_M_S)
    extra = (damper.observer.in_j, 1.0, *sent.x)
    return DeviceEnd(damper, sent), DeviceAnswer(total, sent.signal, extra)


def avatar(s: AvatarEnd, step: AvatarStep, p: Gains) -> tuple[AvatarEnd, AvatarAnswer]:
    """Arrive where the last step led, form the force, choose the velocity from here: that held
    and a share of the lag, as far as the observer allows.
    """
    observer, h = credited(s.observer, step.extra[0]), step.period_s
    x_s = plus(step.x_s, scaled(step.xd_s, h))
    moved = placed_avatar(step._replace(position=x_s), step.wave)
    came = step.extra[2:]
    if step.extra[1] == 0.0:  # a packet from before the first tick has zeros
        aim = step.position
    elif came != s.came:
        aim = plus(came, step.offset)
    else:
        aim = plus(s.aim, scaled(step.wave, h))
    xd = plus(step.wave, scaled(minus(aim, x_s), p.drift_share / h))
    excess_j = h * dot(moved.f, xd) - max(observer.allowance_j, 0.0)
    if excess_j > 0.0 and squared(moved.f) > LEAST:
        xd = minus(xd, scaled(moved.f, excess_j / (h * squared(moved.f))))
    observer = booked(observer, -h * dot(moved.f, xd))
    sent = updated(s.sent, moved.f, (), p.deadband, LEAST_N)
    answer = AvatarAnswer(moved._replace(xd=xd), sent.signal, (observer.in_j,))
    return AvatarEnd(observer, sent, came, aim), answer


DEADBAND_TDPA = Controller(
    name="deadband_tdpa",
    words="Time-domain passivity control of signals that are updated outside a deadband only.",
    waves=False,
    device=device,
    avatar=avatar,
    device_rest=lambda p, axes: DeviceEnd(),
    avatar_rest=lambda p, axes: AvatarEnd(),
    extra=lambda axes: (2 + axes, 1),
    params=Gains,
    coupling=replace(HELD, moves="forward_euler"),
)
