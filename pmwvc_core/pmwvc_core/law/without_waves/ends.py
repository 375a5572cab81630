# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of all controllers without waves, and of those of other packages; what a controller
adds is chosen by type.

The device's end counts what flowed from the hand into the controller and back: the force that the
limits let through times the velocity at the tick. The library's send position and velocity.

At the server the object moves exactly under the last forces held; then every avatar meets it.
``u_j`` is the flow to the avatar, ``v_j`` the flow back, both from f_s xd_s.
"""

from operator import add
from typing import Any, NamedTuple

from pmwvc_core.law.channel.arrivals import PlainArrivals
from pmwvc_core.law.channel.packet import Packet, Sent
from pmwvc_core.law.family import Family, accounts, same
from pmwvc_core.law.motion import Body, BodyLaw, kinetic_j
from pmwvc_core.law.port import master
from pmwvc_core.law.port.master import known_motion
from pmwvc_core.law.server import server_port
from pmwvc_core.law.server.contacts import (
    Avatar,
    Contact,
    contact_force,
    contact_heat,
    offset_of,
    slid,
    springs_j,
)
from pmwvc_core.law.server.coupling import object_pushed, solved_contact
from pmwvc_core.law.server.server_port import Came, SharedScene, UserPort, avatar_of, in_touch
from pmwvc_core.law.vectors import Vector, columns, dot, each, minus, plus, scaled, total, zero
from pmwvc_core.law.wave.wave import impedance, loaded


class DeviceEnd(NamedTuple):
    """A master's end without waves."""

    x: Vector  # [m] last measured
    xd: Vector  # [m/s]
    f: Vector  # [N] as the limits let it through
    law: Any
    given_j: float = 0.0  # from the device into the controller
    taken_j: float = 0.0  # and back


class DeviceEndParams(NamedTuple):
    """Period of a tick [s], and the parameters of the controller."""

    tick_s: float
    law: Any


class FromServer(NamedTuple):
    """The newest packet at an answer tick, of number 0 before the first."""

    packet: Packet
    wave: Vector  # what it carries
    silent: bool
    received_j: float  # by the sums of packets
    frame_s: float


def _sent(law: Any, s: DeviceEnd, frame_s: float, p: DeviceEndParams) -> tuple[Any, Sent]:
    return law, Sent(s.xd, s.x, -1.0, (), 0)


def _passed_j(law: Any, given_j: float, taken_j: float, p: Any) -> Vector:
    return given_j, given_j, taken_j, taken_j


# (law, before, x, xd, p) -> law: moved since the last tick, when the end was that
device_moved = Family("device_moved", same)
device_sends = Family("device_sends", _sent)  # (law, end, frame_s, p) -> (law, Sent)
device_answer = Family("device_answer")  # (law, end, came, p) -> law: once a frame
device_force = Family("device_force")  # (law, end, p) -> (law, force wanted [N])
# (law, given_j, taken_j, p) -> given, sent, received, taken [J]; p of the controller
device_passed_j = Family("device_passed_j", _passed_j)


@master.port_measure.member(DeviceEnd)
def _measure(s: DeviceEnd, x: Vector, xd: Vector, p: DeviceEndParams) -> DeviceEnd:
    x, xd = known_motion(x, xd, s.x)
    return s._replace(x=x, xd=xd, law=device_moved(s.law, s, x, xd, p))


@master.port_send.member(DeviceEnd)
def _send(
    s: DeviceEnd, arrivals: Any, frame_s: float, number: int, held_j: float, p: DeviceEndParams
) -> tuple[DeviceEnd, Any, Sent]:
    law, sent = device_sends(s.law, s, frame_s, p)
    return s._replace(law=law), arrivals, sent


@master.port_answer.member(DeviceEnd)
def _answer(
    s: DeviceEnd, arrivals: PlainArrivals, packet: Packet, wave: Vector, silent: bool,
    frame_s: float, p: DeviceEndParams,
) -> DeviceEnd:  # fmt: skip
    came = FromServer(packet, wave, silent, arrivals.received_j, frame_s)
    return s._replace(law=device_answer(s.law, s, came, p))


@master.port_tick.member(DeviceEnd)
def _tick(
    s: DeviceEnd, arrivals: Any, x: Vector, xd: Vector, p: DeviceEndParams
) -> tuple[DeviceEnd, Any, Vector]:
    s = _measure(s, x, xd, p)
    law, f = device_force(s.law, s, p)
    return s._replace(law=law), arrivals, f


@master.port_passed.member(DeviceEnd)
def _applied(s: DeviceEnd, f: Vector, p: DeviceEndParams) -> DeviceEnd:
    energy_j = p.tick_s * dot(f, s.xd)
    given_j, taken_j = s.given_j + max(energy_j, 0.0), s.taken_j + max(-energy_j, 0.0)
    return DeviceEnd(s.x, s.xd, f, s.law, given_j, taken_j)


@master.port_signals.member(DeviceEnd)
def _signals(s: DeviceEnd) -> tuple[Vector, Vector, Vector]:
    nothing = zero(s.x)
    return nothing, nothing, nothing


@master.port_energies.member(DeviceEnd)
def _energies(s: DeviceEnd, arrivals: Any, p: DeviceEndParams) -> Vector:
    passed: Vector = device_passed_j(s.law, s.given_j, s.taken_j, p.law)
    return passed + accounts(s.law, p.law)


class AvatarEndParams(NamedTuple):
    """The laws of the users, and the object."""

    laws: tuple[Any, ...]
    body: BodyLaw


class AvatarStep(NamedTuple):
    """What an avatar knows in a step; the object has come here under the last forces, held."""

    position: Vector  # [m] of the device as last received, in the avatar's frame
    wave: Vector  # of its packet
    extra: Vector
    x_s: Vector  # [m] after the last step
    xd_s: Vector  # [m/s]
    f_s: Vector  # [N] on the object
    contact: Contact
    body: Body  # the object: x [m], xd [m/s]
    period_s: float
    offset: Vector = ()  # [m] of the avatar's frame in the device's
    received_j: float = 0.0  # by the sums of packets


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
    sent_j: float = -1.0  # running sum of energy; below zero: none


# (p of the controller, kept, step) -> (kept, AvatarAnswer)
avatar_moved = Family("avatar_moved")


def pulled_avatar(step: AvatarStep, drive: Vector, damping: float) -> Moved:
    """Let an avatar without mass move by f_s = drive - damping xd_s against its contact (backward
    Euler): a force [N] and a damper [N s/m]. A spring K and damper B to the device are drive = K
    (position - x_s) + B velocity, damping = K h + B.
    """
    body, h, b = step.body, step.period_s, impedance(damping)
    free = scaled(drive, b.inverse)
    f = solved_contact(b, step.contact, free, body.xd, h)
    xd = loaded(b, free, f)
    contact, lost_j = slid(step.contact, scaled(xd, h))
    lost_j += h * contact_heat(contact, minus(xd, body.xd))
    return Moved(plus(body.x, offset_of(contact)), xd, f, contact, lost_j)


def placed_avatar(step: AvatarStep, velocity: Vector) -> Moved:
    """Put an avatar where its device was when it was last received, with that velocity [m/s]."""
    place = plus(step.body.x, offset_of(step.contact))
    contact, lost_j = slid(step.contact, minus(step.position, place))
    rate = minus(velocity, step.body.xd)
    lost_j += step.period_s * contact_heat(contact, rate)
    x_s = plus(step.body.x, offset_of(contact))
    return Moved(x_s, velocity, contact_force(contact, rate), contact, lost_j)


@server_port.environment_step.member(AvatarEndParams)
def _step(p: AvatarEndParams, s: SharedScene, came: tuple[Came, ...]) -> SharedScene:
    avatars, body, lost_j = object_pushed(each(avatar_of, (s.ports,)), s.body, p.body)
    rows = (s.ports, avatars, came, p.laws)
    ports, lost = columns(each(_moved, rows, body, p.body.period_s))
    return SharedScene(ports, body, s.dissipated_j + total(lost_j, lost), s.unsettled)


def _moved(
    s: UserPort, a: Avatar, came: Came, law: Any, body: Body, h: float
) -> tuple[UserPort, float]:
    if not a.present:
        return s, 0.0
    step = AvatarStep(
        plus(came.position, s.offset), came.wave, came.extra, s.x_s, a.xd, a.f, a.contact, body,
        h, s.offset, came.received_j,
    )  # fmt: skip
    kept, answer = avatar_moved(law, s.brake, step)
    x_s, xd, f, contact, lost_j = answer.moved
    avatar, flow_j = a._replace(xd=xd, f=f, contact=contact), h * dot(f, xd)
    u_j, v_j = s.u_j + max(flow_j, 0.0), s.v_j + max(-flow_j, 0.0)
    s = s._replace(avatar=avatar, brake=kept, x_s=x_s, v_s=answer.wave, u_j=u_j, v_j=v_j)
    return s._replace(account_j=answer.sent_j, extra=answer.extra), lost_j


@server_port.scene_energies.member(AvatarEndParams)
def _scene_energies(p: AvatarEndParams, s: SharedScene) -> Vector:
    kept = accounts(s.ports[0].brake, p.laws[0])
    for i in range(1, len(s.ports)):
        kept = each(add, (kept, accounts(s.ports[i].brake, p.laws[i])))
    avatars = each(avatar_of, (s.ports,))
    stored: Vector = kinetic_j(s.body, p.body), springs_j(avatars)
    return stored + kept


@server_port.port_shown.member(AvatarEndParams)
def _shown(p: AvatarEndParams, s: SharedScene, user: int) -> server_port.PortShown:
    port = s.ports[user]
    return server_port.PortShown(zero(port.v_s), in_touch(port), 0.0)
