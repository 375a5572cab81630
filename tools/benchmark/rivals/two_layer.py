# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Two-layer bilateral control (Franken, Stramigioli, Misra, Secchi and Macchelli, T-RO 2011).

Transparency layer, position-force: the device renders the avatar's force, the avatar is pulled
by a spring and damper to the device's position. Passivity layer below it: a tank H at each end::

    H(k+1)  = H(k) + F dx - sent + received        F dx: work of the force held, exact
    sent    = beta H                               simple energy transfer protocol, both ways
    |F|    <= 0 where H <= 0,    H/(|xd| T) where F gives out,    H/(V T)
    F_tlc   = d xd,   d = alpha (H_d - H) where H < H_d    tank level controller, device only

Tanks start empty; the tank level controller fills them, so the two ports never release more than
they took in, with any delay or loss.

Adapted: the transfer goes by time, beta = T/(T + transfer_s), as the ends run at 1 kHz and 125
Hz; it is a running sum, so that a lost packet loses no energy. The paper leaves the last bound
open, a map of the level chosen by the user: here what the tank can pay at V = 0.5 m/s, so that a
device that speeds up within a tick does not overdraw. The avatar has no mass and is solved with
its contact; in place of its force's bound its drive is scaled until the step takes H at most.

The paper was not at hand: its equations are given from memory, its gains are not.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

from benchmark.rivals.energy import Place, Received, paid_avatar, received, released_j, work_j
from pmwvc_core.controllers.plugged import AvatarAnswer, AvatarStep, DeviceAnswer, DeviceTick
from pmwvc_core.controllers.record import HELD, Controller
from pmwvc_core.law.vectors import dot, length, minus, plus, scaled, shortened, zero
from pmwvc_core.params.fields import Validated, parameter

SPEED_M_S = 0.5  # V
RANGES = {
    "stiffness": (200.0, 5000.0),
    "damping": (1.0, 30.0),
    "local": (1.0, 25.0),
    "level_j": (5e-3, 0.2),
    "gain": (50.0, 3000.0),
    "transfer_s": (0.02, 0.5),
}


@dataclass(frozen=True)
class Gains(Validated):
    """Both layers."""

    stiffness: float = parameter(1000.0, "> 0 N/m", "spring of the avatar to the device")
    damping: float = parameter(5.0, ">= 0 N s/m", "damper beside it")
    local: float = parameter(12.0, ">= 0 N s/m", "local damping of the device")
    level_j: float = parameter(0.04, "> 0 J", "desired level of the device's tank, H_d")
    gain: float = parameter(500.0, ">= 0 N s/m/J", "of the tank level controller, alpha")
    transfer_s: float = parameter(0.1, "> 0 s", "time in which a tank gives itself to the other")


class Tank(NamedTuple):
    """An end."""

    level_j: float = 0.0  # H
    sent_j: float = 0.0  # running sum
    came: Received = Received()
    place: Place = Place()


def shared(s: Tank, time_s: float, p: Gains) -> Tank:
    """Send a share of the level."""
    sent_j = max(s.level_j, 0.0) * time_s / (time_s + p.transfer_s)
    return s._replace(level_j=s.level_j - sent_j, sent_j=s.sent_j + sent_j)


def filled(s: Tank, sum_j: float) -> Tank:
    """Take in what the other end has sent."""
    came, gained = received(s.came, sum_j)
    return s._replace(level_j=s.level_j + gained, came=came)


def most_n(level_j: float, force: Any, tick: DeviceTick) -> float:
    """Return the largest force that a tank can pay for [N]."""
    if level_j <= 0.0:
        return 0.0
    speed = length(tick.xd) if dot(force, tick.xd) < 0.0 else 0.0
    return level_j / (max(speed, SPEED_M_S) * tick.tick_s)


def device(s: Tank, tick: DeviceTick, p: Gains) -> tuple[Tank, DeviceAnswer]:
    """Count the last tick, render what the tank allows, fill it by damping."""
    place, taken_j = work_j(s.place, tick)
    s = s._replace(level_j=s.level_j + taken_j, place=place)
    force = zero(tick.x)
    if tick.packet.number > 0:
        s = filled(s, tick.packet.extra[0])
        force = zero(tick.x) if tick.silent else tick.packet.wave
    force = plus(force, scaled(tick.xd, p.local))
    s = shared(s, tick.tick_s, p)
    force = shortened(force, most_n(s.level_j, force, tick))
    damping = p.gain * max(p.level_j - s.level_j, 0.0)
    force = plus(force, scaled(tick.xd, damping))
    return s, DeviceAnswer(force, tick.xd, (s.sent_j,))


def avatar(s: Tank, step: AvatarStep, p: Gains) -> tuple[Tank, AvatarAnswer]:
    """Pull the avatar as far as its tank can pay."""
    s = filled(s, step.extra[0])
    drive = plus(scaled(minus(step.position, step.x_s), p.stiffness), scaled(step.wave, p.damping))
    impedance = p.stiffness * step.period_s + p.damping
    moved = paid_avatar(step, drive, impedance, max(s.level_j, 0.0))
    s = shared(s._replace(level_j=s.level_j - released_j(step, moved)), step.period_s, p)
    return s, AvatarAnswer(moved, moved.f, (s.sent_j,))


TWO_LAYER = Controller(
    name="two_layer",
    words="Two layers: neither end releases more energy than its tank holds.",
    waves=False,
    device=device,
    avatar=avatar,
    device_rest=lambda p, axes: Tank(),
    avatar_rest=lambda p, axes: Tank(),
    extra=lambda axes: (1, 1),
    params=Gains,
    coupling=HELD,
)
