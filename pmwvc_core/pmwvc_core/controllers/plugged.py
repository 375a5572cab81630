# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ends of a controller of another package: a function for each end, and a state of its own.

::

    device(s, DeviceTick, p) -> (s, DeviceAnswer)      at every tick of a force loop
    avatar(s, AvatarStep, p) -> (s, AvatarAnswer)      for every user in every step of the server

Each is a pure function of plain numbers, like the laws of the library: states are NamedTuples, and
``p`` are the controller's parameters. A controller whose packets carry waves may have the first
one only; its users then meet the environment behind the wave ports of the plain channel.

What a packet carries is up to the controller: ``wave``, and any number of ``extra`` signals beside
it, always as many. The position of the device, or of the avatar in the frame of its device, is in
every packet. A deadband and the energies of waves look at ``wave`` alone.
"""

from typing import NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.server.body import Body
from pmwvc_core.law.server.contacts import (
    Contact,
    contact_force,
    contact_heat,
    contact_unwrapped,
    offset_of,
    slid,
)
from pmwvc_core.law.vectors import Vector, minus, plus, scaled


class DeviceTick(NamedTuple):
    """What the device's end knows at a tick."""

    x: Vector  # [m]
    xd: Vector  # [m/s]
    packet: Packet  # the newest; of zeros before the first, and its wave also in a silence
    silent: bool  # no packets come
    answered: bool  # the packet counts from this tick on
    applied: Vector  # [N] force of the tick before, as the limits let it through
    tick_s: float


class DeviceAnswer(NamedTuple):
    """The force against the hand [N], and what the next packet carries."""

    force: Vector
    wave: Vector
    extra: Vector = ()


class AvatarStep(NamedTuple):
    """What an avatar knows in a step; the object has come here under the last forces, held."""

    position: Vector  # [m] of the device as last heard, in the avatar's frame
    wave: Vector  # of its packet
    extra: Vector
    x_s: Vector  # [m] after the last step
    xd_s: Vector  # [m/s]
    f_s: Vector  # [N] on the object
    contact: Contact
    body: Body  # the object: x [m], xd [m/s]
    period_s: float


class Moved(NamedTuple):
    """An avatar after its step."""

    x_s: Vector
    xd: Vector
    f: Vector  # [N] on the object
    contact: Contact
    lost_j: float  # heat of the contact, springs let go


class AvatarAnswer(NamedTuple):
    """Where the avatar went, and what goes back to the device."""

    moved: Moved
    wave: Vector
    extra: Vector = ()


def pulled_avatar(step: AvatarStep, drive: Vector, impedance: float) -> Moved:
    """Let an avatar without mass move by f_s = drive - impedance xd_s against its contact
    (backward Euler): a force [N] and a damper [N s/m]. A spring K and damper B to the device are
    drive = K (position - x_s) + B velocity, impedance = K h + B.
    """
    free = scaled(drive, 1.0 / impedance)
    f = contact_unwrapped(step.contact, free, step.body.xd, impedance, step.period_s)
    xd = minus(free, scaled(f, 1.0 / impedance))
    contact, dropped_j = slid(step.contact, scaled(xd, step.period_s))
    lost_j = dropped_j + step.period_s * contact_heat(contact, minus(xd, step.body.xd))
    return Moved(plus(step.body.x, offset_of(contact)), xd, f, contact, lost_j)


def placed_avatar(step: AvatarStep, velocity: Vector) -> Moved:
    """Put an avatar where its device was when it was last heard, with that velocity [m/s]."""
    place = plus(step.body.x, offset_of(step.contact))
    contact, dropped_j = slid(step.contact, minus(step.position, place))
    rate = minus(velocity, step.body.xd)
    f, lost_j = contact_force(contact, rate), step.period_s * contact_heat(contact, rate)
    return Moved(plus(step.body.x, offset_of(contact)), velocity, f, contact, lost_j + dropped_j)
