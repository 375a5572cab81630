# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Direct coupling and virtual coupling: neither keeps an account of energy.

Direct: position and velocity go up each frame, the contact force comes back, held (App. B, Fig.
3). It is not passive: the force is as old as the way there and back. An avatar stands where its
device stood when it last reported; ``xd_s`` is the velocity as reported::

    f_s(n) = K [x_m + offset - x_o(n)] + B [xd_m - xd_o(n)],    F_m = f_s as last received

Virtual coupling: spring and damper between device and avatar, at 1 kHz on the device's side
(Colgate, Stanley and Brown 1995; Adams and Hannaford 1999)::

    F_m = K_c (x_m - p) + B_c (xd_m - p')          p: avatar, in the device's frame, as received
    f_s = K_c (x_m - p) + B_c (xd_m - p')          x_m: device, as received
    p'  the avatar's mean velocity between the last two packets
"""

from typing import Any, NamedTuple

from pmwvc_core.law.family import Nothing
from pmwvc_core.law.vectors import Vector, minus, plus, scaled, zero
from pmwvc_core.law.without_waves import ends
from pmwvc_core.law.without_waves.ends import AvatarAnswer, DeviceEnd, placed_avatar, pulled_avatar


class Held(NamedTuple):
    """The force as last received [N]."""

    force: Vector


class Direct(Nothing):
    """The law at either end; it has no parameters."""


@ends.device_answer.member(Held)
def _held(s: Held, end: DeviceEnd, came: ends.FromServer, p: ends.DeviceEndParams) -> Held:
    return Held(zero(came.wave) if came.silent else came.wave)


@ends.device_force.member(Held)
def _force(s: Held, end: DeviceEnd, p: ends.DeviceEndParams) -> tuple[Held, Vector]:
    return s, s.force


@ends.avatar_moved.member(Direct)
def _placed(p: Direct, kept: Any, step: ends.AvatarStep) -> tuple[Any, AvatarAnswer]:
    moved = placed_avatar(step, step.wave)
    return kept, AvatarAnswer(moved, moved.f, (), -1.0)


class VirtualCoupling(NamedTuple):
    """The law at either end: K_c [N/m] and B_c [N s/m]."""

    stiffness: float
    damping: float


class AvatarSeen(NamedTuple):
    """The avatar as last received: p [m], p' [m/s]; of which packet, 0 before the first."""

    p: Vector
    pd: Vector
    number: int = 0
    sent_ns: int = 0
    coupled: bool = False


@ends.device_answer.member(AvatarSeen)
def _seen(
    s: AvatarSeen, end: DeviceEnd, came: ends.FromServer, p: ends.DeviceEndParams
) -> AvatarSeen:
    """Take the avatar's velocity from the way it went since the packet before."""
    packet, pd = came.packet, s.pd
    numbers = packet.number - s.number
    another = packet.fresh and packet.sent_ns != s.sent_ns
    if s.number == 0 or numbers < 0 or another or not s.coupled:
        pd = zero(packet.wave)
    elif numbers > 0:
        pd = scaled(minus(packet.wave, s.p), 1.0 / (packet.period_s * numbers))
    at = s.p if came.silent else came.wave
    return AvatarSeen(at, pd, packet.number, packet.sent_ns, not came.silent)


@ends.device_force.member(AvatarSeen)
def _pull(s: AvatarSeen, end: DeviceEnd, p: ends.DeviceEndParams) -> tuple[AvatarSeen, Vector]:
    pull = scaled(minus(end.x, s.p), p.law.stiffness)
    drag = scaled(minus(end.xd, s.pd), p.law.damping)
    return s, plus(pull, drag) if s.coupled else zero(end.x)


@ends.avatar_moved.member(VirtualCoupling)
def _pulled(p: VirtualCoupling, kept: Any, step: ends.AvatarStep) -> tuple[Any, AvatarAnswer]:
    pull = scaled(minus(step.position, step.x_s), p.stiffness)
    drive = plus(pull, scaled(step.wave, p.damping))
    moved = pulled_avatar(step, drive, p.stiffness * step.period_s + p.damping)
    return kept, AvatarAnswer(moved, minus(moved.x_s, step.offset), (), -1.0)
