# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ends of a controller of another package: a function for each end, and a state of its own.

::

    device(s, DeviceTick, p) -> (s, DeviceAnswer)      at every tick of a force loop
    avatar(s, AvatarStep, p) -> (s, AvatarAnswer)      for every user in every step of the server

Each is a pure function of plain numbers: states are NamedTuples, ``p`` are the controller's
parameters. A controller whose packets carry waves may have the first one only; its users then meet
the environment behind the wave ports of the plain channel.

A packet carries the position of the device, or of the avatar in the frame of its device, and what
the controller chooses: ``wave``, and any number of ``extra`` signals beside it, always as many. A
deadband and the energies of waves look at ``wave`` alone.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from pmwvc_core.law.channel.packet import Packet, Sent
from pmwvc_core.law.motion import Body, BodyLaw, kinetic_j
from pmwvc_core.law.port import master
from pmwvc_core.law.port.master import known_motion
from pmwvc_core.law.safety.brakes import released_brake
from pmwvc_core.law.server import server_port
from pmwvc_core.law.server.contacts import Contact, contact_force, contact_heat, offset_of, slid
from pmwvc_core.law.server.coupling import object_pushed, pulled
from pmwvc_core.law.server.server_port import SharedScene
from pmwvc_core.law.vectors import Vector, dot, minus, plus, squared, zero
from pmwvc_core.law.without_waves.ends import port_without_waves


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
    xd, f, contact, lost_j = pulled(step.contact, drive, impedance, step.body, step.period_s)
    return Moved(plus(step.body.x, offset_of(contact)), xd, f, contact, lost_j)


def placed_avatar(step: AvatarStep, velocity: Vector) -> Moved:
    """Put an avatar where its device was when it was last heard, with that velocity [m/s]."""
    place = plus(step.body.x, offset_of(step.contact))
    contact, dropped_j = slid(step.contact, minus(step.position, place))
    rate = minus(velocity, step.body.xd)
    f, lost_j = contact_force(contact, rate), step.period_s * contact_heat(contact, rate)
    return Moved(plus(step.body.x, offset_of(contact)), velocity, f, contact, lost_j + dropped_j)


class Plugged(NamedTuple):
    """A device's end, by which the families of :mod:`pmwvc_core.law.port.master` find it."""

    law: Any
    x: Vector  # [m]
    xd: Vector  # [m/s]
    packet: Packet
    silent: bool
    answered: bool
    answer: DeviceAnswer
    applied: Vector  # [N]
    given_j: float  # to the controller, and taken from it
    taken_j: float
    sent_j: float  # by waves, and received by them
    received_j: float


class PluggedParams(NamedTuple):
    """The law and its parameters; whether packets carry waves."""

    device: Callable[..., Any]
    values: Any
    energies: Callable[..., Vector]
    tick_s: float
    waves: bool


@master.port_measure.member(Plugged)
def _measure(s: Plugged, x: Vector, xd: Vector, p: PluggedParams) -> Plugged:
    x, xd = known_motion(x, xd, s.x)
    return s._replace(x=x, xd=xd)


@master.port_send.member(Plugged)
def _send(
    s: Plugged, arrivals: Any, frame_s: float, number: int, held_j: float, p: PluggedParams
) -> tuple[Plugged, Any, Sent]:
    wave, extra = s.answer.wave, s.answer.extra
    s = s._replace(sent_j=s.sent_j + squared(wave) * (0.5 * frame_s))
    return s, arrivals, Sent(wave, s.x, -1.0, extra)


@master.port_answer.member(Plugged)
def _answer(
    s: Plugged, arrivals: Any, packet: Packet, wave: Vector, silent: bool, frame_s: float,
    p: PluggedParams,
) -> Plugged:  # fmt: skip
    wave = zero(wave) if silent else wave
    received_j = s.received_j + squared(wave) * (0.5 * frame_s)
    packet = (packet if packet.number > 0 else s.packet)._replace(wave=wave)
    return s._replace(packet=packet, silent=silent, answered=True, received_j=received_j)


@master.port_tick.member(Plugged)
def _tick(
    s: Plugged, arrivals: Any, x: Vector, xd: Vector, p: PluggedParams
) -> tuple[Plugged, Any, Vector]:
    s = _measure(s, x, xd, p)
    tick = DeviceTick(s.x, s.xd, s.packet, s.silent, s.answered, s.applied, p.tick_s)
    law, answer = p.device(s.law, tick, p.values)
    return s._replace(law=law, answer=answer, answered=False), arrivals, answer.force


@master.port_applied.member(Plugged)
def _applied(s: Plugged, f: Vector, p: PluggedParams) -> Plugged:
    energy_j = p.tick_s * dot(f, s.xd)
    given_j, taken_j = s.given_j + max(energy_j, 0.0), s.taken_j + max(-energy_j, 0.0)
    return s._replace(applied=f, given_j=given_j, taken_j=taken_j)


@master.port_energies.member(Plugged)
def _energies(s: Plugged, arrivals: Any, p: PluggedParams) -> Vector:
    sent_j, received_j = (s.sent_j, s.received_j) if p.waves else (s.given_j, s.taken_j)
    return s.given_j, sent_j, received_j, s.taken_j, *p.energies(s.law)


class Kept(NamedTuple):
    """What the law keeps of an avatar, and what it starts from whenever the user joins."""

    law: Any
    rest: Any


class PluggedServerParams(NamedTuple):
    """The law and the parameters of each user; the object."""

    avatar: Callable[..., Any]
    values: tuple[Any, ...]
    energies: Callable[..., Vector]
    body: BodyLaw


@server_port.environment_step.member(PluggedServerParams)
def _step(p: PluggedServerParams, s: SharedScene, came: tuple[Any, ...]) -> SharedScene:
    avatars, body, lost_j = object_pushed(tuple(port.avatar for port in s.ports), s.body, p.body)
    ports, h = [], p.body.period_s
    for port, a, packet, values in zip(s.ports, avatars, came, p.values, strict=True):
        if not a.present:
            ports.append(port)
            continue
        position, at = plus(packet.position, port.offset), (port.x_s, a.xd, a.f, a.contact)
        step = AvatarStep(position, packet.wave, packet.extra, *at, body, h)
        law, (moved, wave, extra) = p.avatar(port.brake.law, step, values)
        flow_j = h * dot(moved.f, moved.xd)
        ports.append(port._replace(
            avatar=a._replace(xd=moved.xd, f=moved.f, contact=moved.contact),
            brake=port.brake._replace(law=law), x_s=moved.x_s, v_s=wave, extra=extra,
            u_j=port.u_j + max(flow_j, 0.0), v_j=port.v_j + max(-flow_j, 0.0),
        ))  # fmt: skip
        lost_j += moved.lost_j
    return SharedScene(tuple(ports), body, s.dissipated_j + lost_j, s.unsettled)


@server_port.environment_energies.member(PluggedServerParams)
def _environment_energies(p: PluggedServerParams, s: SharedScene) -> Vector:
    of_users = zip(*[p.energies(port.brake.law) for port in s.ports], strict=True)
    return kinetic_j(s.body, p.body), server_port.potential_j(s), *map(sum, of_users)


master.port_signals.member(Plugged)(lambda s: (zero(s.x),) * 3)
released_brake.member(Kept)(lambda s: Kept(s.rest, s.rest))
server_port.port_shown.member(PluggedServerParams)(port_without_waves)
