# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of all controllers without waves. What a controller adds is chosen by type.

The device's end sends where the device is and how fast it moves, and counts what flowed from the
hand into the controller and back: the force that the limits let through times the velocity at the
tick. The wave signals are zero.

At the server the object moves exactly under the last forces held; then every avatar meets it, each
by itself. ``u_j`` is the flow to the avatar, ``v_j`` the flow back, both from f_s xd_s. An avatar
goes along with the device (``direct``, ``tdpa``; the force goes back), or hangs on spring and
damper (``virtual_coupling``, ``pspm``; its position goes back, in the device's frame).
"""

from operator import add
from typing import Any, NamedTuple

from pmwvc_core.law.channel.arrivals import PlainArrivals
from pmwvc_core.law.channel.packet import Packet, Sent
from pmwvc_core.law.family import Family, no_accounts, same
from pmwvc_core.law.motion import Body, BodyLaw, kinetic_j
from pmwvc_core.law.port import master
from pmwvc_core.law.port.master import known_motion
from pmwvc_core.law.server.contacts import Avatar, Contact, offset_of
from pmwvc_core.law.server.coupling import object_pushed
from pmwvc_core.law.server.server_port import (
    Came,
    PortShown,
    SharedScene,
    UserPort,
    avatar_of,
    environment_energies,
    environment_step,
    in_touch,
    port_shown,
    potential_j,
)
from pmwvc_core.law.vectors import Vector, columns, dot, each, minus, plus, total, zero


class DeviceEnd(NamedTuple):
    """A master's end without waves."""

    x: Vector  # [m] last measured
    xd: Vector  # [m/s]
    law: Any
    given_j: float = 0.0  # from the device into the controller
    taken_j: float = 0.0  # and back


class DeviceEndParams(NamedTuple):
    """Period of a tick [s], and the parameters of the controller."""

    tick_s: float
    law: Any


def _no_energy(law: Any, p: DeviceEndParams) -> tuple[Any, float]:
    return law, -1.0


def _held(law: Any, wave: Vector, silent: bool, x: Vector, p: DeviceEndParams) -> Any:
    return law._replace(force=zero(wave) if silent else wave)


# (law, before, x, xd, p) -> law: moved since the last tick, when the end was that
device_moved = Family("device_moved", same)
# (law, p) -> (law, running sum of energy; below zero: none)
device_sends = Family("device_sends", _no_energy)
# once a frame, (law, packet, received_j, p) -> law: the newest, of number 0 before the first
device_receives = Family("device_receives", same)
# then (law, wave, silent, x, p) -> law: what it carries, or let go
device_answer = Family("device_answer", _held)
device_force = Family("device_force")  # (law, x, xd, p) -> (law, force wanted [N])
# (state at either end) -> accounts [J]
controller_energies = Family("controller_energies", no_accounts)
device_applied = Family("device_applied", same)  # (law, f, p) -> law: the force let through [N]


@master.port_measure.member(DeviceEnd)
def _measure(s: DeviceEnd, x: Vector, xd: Vector, p: DeviceEndParams) -> DeviceEnd:
    x, xd = known_motion(x, xd, s.x)
    return s._replace(x=x, xd=xd, law=device_moved(s.law, s, x, xd, p))


@master.port_send.member(DeviceEnd)
def _send(
    s: DeviceEnd, arrivals: Any, frame_s: float, number: int, held_j: float, p: DeviceEndParams
) -> tuple[DeviceEnd, Any, Sent]:
    law, energy_j = device_sends(s.law, p)
    return s._replace(law=law), arrivals, Sent(s.xd, s.x, energy_j, ())


@master.port_answer.member(DeviceEnd)
def _answer(
    s: DeviceEnd, arrivals: PlainArrivals, packet: Packet, wave: Vector, silent: bool,
    frame_s: float, p: DeviceEndParams,
) -> DeviceEnd:  # fmt: skip
    law = device_receives(s.law, packet, arrivals.received_j, p)
    return s._replace(law=device_answer(law, wave, silent, s.x, p))


@master.port_tick.member(DeviceEnd)
def _tick(
    s: DeviceEnd, arrivals: Any, x: Vector, xd: Vector, p: DeviceEndParams
) -> tuple[DeviceEnd, Any, Vector]:
    s = _measure(s, x, xd, p)
    law, f = device_force(s.law, s.x, s.xd, p)
    return s._replace(law=law), arrivals, f


@master.port_applied.member(DeviceEnd)
def _applied(s: DeviceEnd, f: Vector, p: DeviceEndParams) -> DeviceEnd:
    energy_j = p.tick_s * dot(f, s.xd)
    given_j, taken_j = s.given_j + max(energy_j, 0.0), s.taken_j + max(-energy_j, 0.0)
    return DeviceEnd(s.x, s.xd, device_applied(s.law, f, p), given_j, taken_j)


@master.port_signals.member(DeviceEnd)
def _signals(s: DeviceEnd) -> tuple[Vector, Vector, Vector]:
    nothing = zero(s.x)
    return nothing, nothing, nothing


@master.port_energies.member(DeviceEnd)
def _energies(s: DeviceEnd, arrivals: Any, p: DeviceEndParams) -> Vector:
    of_port: Vector = (s.given_j, s.given_j, s.taken_j, s.taken_j)
    return of_port + controller_energies(s.law)


class AvatarEndParams(NamedTuple):
    """The laws of the users, the object, whether the avatars hang on springs."""

    laws: tuple[Any, ...]
    body: BodyLaw
    sprung: bool


class Met(NamedTuple):
    """An avatar after its step."""

    kept: Any
    xd: Vector  # [m/s]
    f: Vector  # [N] on the object
    contact: Contact
    lost_j: float  # heat of the contact, springs let go
    sent_j: float  # running sum for the packets; below zero: none


# (law, port, avatar, came, body, h) -> Met: move an avatar and form its force; the position that
# came is in the avatar's frame
meet = Family("meet")


@environment_step.member(AvatarEndParams)
def _step(p: AvatarEndParams, s: SharedScene, came: tuple[Came, ...]) -> SharedScene:
    avatars, body, lost_j = object_pushed(each(avatar_of, (s.ports,)), s.body, p.body)
    rows = (s.ports, avatars, came, p.laws)
    ports, lost = columns(each(_meet, rows, body, p.body.period_s, p.sprung))
    return SharedScene(ports, body, s.dissipated_j + total(lost_j, lost), s.unsettled)


def _meet(
    s: UserPort, a: Avatar, came: Came, law: Any, body: Body, h: float, sprung: bool
) -> tuple[UserPort, float]:
    if not a.present:
        return s, 0.0
    met = meet(law, s, a, came._replace(position=plus(came.position, s.offset)), body, h)
    avatar = a._replace(xd=met.xd, f=met.f, contact=met.contact)
    x_s = plus(body.x, offset_of(met.contact))
    answer = minus(x_s, s.offset) if sprung else met.f
    flow_j = h * dot(met.f, met.xd)
    u_j, v_j = s.u_j + max(flow_j, 0.0), s.v_j + max(-flow_j, 0.0)
    s = UserPort(avatar, met.kept, s.offset, x_s, answer, u_j, v_j, met.sent_j, s.extra)
    return s, met.lost_j


@environment_energies.member(AvatarEndParams)
def _environment_energies(p: AvatarEndParams, s: SharedScene) -> Vector:
    accounts = controller_energies(s.ports[0].brake)
    for i in range(1, len(s.ports)):
        accounts = each(add, (accounts, controller_energies(s.ports[i].brake)))
    stored: Vector = (kinetic_j(s.body, p.body), potential_j(s))
    return stored + accounts


@port_shown.member(AvatarEndParams)
def port_without_waves(p: Any, s: SharedScene, user: int) -> PortShown:
    """Return a port whose waves are none."""
    port = s.ports[user]
    return PortShown(zero(port.v_s), in_touch(port), 0.0)
