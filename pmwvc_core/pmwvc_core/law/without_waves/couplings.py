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

p' is the avatar's mean velocity between the last two packets. Passive without delay where the
device's damping b exceeds K_c T_c/2 + B_c; with delays T_1 + T_2 around the loop K_c (T_1 + T_2)/2
<= B_c + b is required. Neither rule excludes generated energy.
"""

from typing import NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.family import Nothing
from pmwvc_core.law.motion import Body
from pmwvc_core.law.server.contacts import Avatar, contact_force, contact_heat, offset_of, slid
from pmwvc_core.law.server.coupling import pulled
from pmwvc_core.law.server.server_port import Came, UserPort
from pmwvc_core.law.vectors import Vector, minus, plus, scaled, zero
from pmwvc_core.law.without_waves import ends
from pmwvc_core.law.without_waves.ends import DeviceEndParams, Met, meet


class Held(NamedTuple):
    """The force as last received [N]."""

    force: Vector


class Direct(Nothing):
    """The law at either end; it has no parameters."""


@ends.device_force.member(Held)
def _force(s: Held, x: Vector, xd: Vector, p: DeviceEndParams) -> tuple[Held, Vector]:
    return s, s.force


@meet.member(Direct)
def _meet(p: Direct, s: UserPort, a: Avatar, came: Came, body: Body, h: float) -> Met:
    place = plus(body.x, offset_of(a.contact))
    contact, lost_j = slid(a.contact, minus(came.position, place))
    rate = minus(came.wave, body.xd)
    f = contact_force(contact, rate)
    lost_j += h * contact_heat(contact, rate)
    return Met(s.brake, came.wave, f, contact, lost_j, -1.0)


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


@ends.device_receives.member(AvatarSeen)
def _receives(s: AvatarSeen, packet: Packet, received_j: float, p: DeviceEndParams) -> AvatarSeen:
    """Take the avatar's velocity from the way it went since the packet before."""
    pd, numbers = s.pd, packet.number - s.number
    another = packet.fresh and packet.sent_ns != s.sent_ns
    if s.number == 0 or numbers < 0 or another or not s.coupled:
        pd = zero(packet.wave)
    elif numbers > 0:
        pd = scaled(minus(packet.wave, s.p), 1.0 / (packet.period_s * numbers))
    return AvatarSeen(s.p, pd, packet.number, packet.sent_ns, s.coupled)


@ends.device_answer.member(AvatarSeen)
def _noted(s: AvatarSeen, wave: Vector, silent: bool, x: Vector, p: DeviceEndParams) -> AvatarSeen:
    return s._replace(p=s.p if silent else wave, coupled=not silent)


@ends.device_force.member(AvatarSeen)
def _pull(s: AvatarSeen, x: Vector, xd: Vector, p: DeviceEndParams) -> tuple[AvatarSeen, Vector]:
    pull, drag = scaled(minus(x, s.p), p.law.stiffness), scaled(minus(xd, s.pd), p.law.damping)
    return s, plus(pull, drag) if s.coupled else zero(x)


@meet.member(VirtualCoupling)
def _pulled(p: VirtualCoupling, s: UserPort, a: Avatar, came: Came, body: Body, h: float) -> Met:
    stretch = minus(came.position, s.x_s)
    drive = plus(scaled(stretch, p.stiffness), scaled(came.wave, p.damping))
    xd, f, contact, lost_j = pulled(a.contact, drive, p.stiffness * h + p.damping, body, h)
    return Met(s.brake, xd, f, contact, lost_j, -1.0)
