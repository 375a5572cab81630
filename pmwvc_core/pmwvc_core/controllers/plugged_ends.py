# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The laws of a controller of another package (:mod:`.plugged`) as members of the families: as the
port of a device, and as the avatars at the object.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from pmwvc_core.controllers.plugged import AvatarStep, DeviceAnswer, DeviceTick
from pmwvc_core.law.channel.packet import Packet, Sent
from pmwvc_core.law.port.master import (
    port_answer,
    port_applied,
    port_energies,
    port_measure,
    port_packet,
    port_send,
    port_signals,
    port_tick,
)
from pmwvc_core.law.port.sensing import known_motion
from pmwvc_core.law.safety.brakes import released_brake
from pmwvc_core.law.server.avatar import Avatar
from pmwvc_core.law.server.body import Body, BodyLaw, kinetic_j
from pmwvc_core.law.server.sampled import object_pushed
from pmwvc_core.law.server.server_port import (
    Environment,
    UserPort,
    environment_energies,
    environment_step,
    port_shown,
    potential_j,
)
from pmwvc_core.law.vectors import Vector, dot, plus, squared, zero
from pmwvc_core.law.without_waves.avatar_end import port_without_waves


class Plugged(NamedTuple):
    """A device's end."""

    law: Any
    x: Vector  # [m]
    xd: Vector  # [m/s]
    packet: Packet
    silent: bool
    answered: bool
    answer: DeviceAnswer
    applied: Vector  # [N]
    energies: Vector  # [J] given to and taken from the controller; sent and received by waves


class PluggedParams(NamedTuple):
    """The law and its parameters; whether packets carry waves."""

    device: Callable[..., Any]
    values: Any
    energies: Callable[..., Vector]
    tick_s: float
    waves: bool


@port_measure.member(Plugged)
def _measure(s: Plugged, x: Vector, xd: Vector, p: PluggedParams) -> Plugged:
    x, xd = known_motion(x, xd, s.x)
    return s._replace(x=x, xd=xd)


@port_send.member(Plugged)
def _send(
    s: Plugged, arrivals: Any, frame_s: float, number: int, held_j: float, p: PluggedParams
) -> tuple[Plugged, Any, Sent]:
    (given, taken, sent_j, received_j), answer = s.energies, s.answer
    sent_j += squared(answer.wave) * (0.5 * frame_s)
    s = s._replace(energies=(given, taken, sent_j, received_j))
    return s, arrivals, Sent(answer.wave, s.x, -1.0, answer.extra)


@port_packet.member(Plugged)
def _packet(s: Plugged, arrivals: Any, packet: Packet, p: PluggedParams) -> Plugged:
    return s._replace(packet=packet)


@port_answer.member(Plugged)
def _answer(s: Plugged, wave: Vector, silent: bool, frame_s: float, p: PluggedParams) -> Plugged:
    wave = zero(wave) if silent else wave
    given, taken, sent_j, received_j = s.energies
    received_j += squared(wave) * (0.5 * frame_s)
    packet, energies = s.packet._replace(wave=wave), (given, taken, sent_j, received_j)
    return s._replace(packet=packet, silent=silent, answered=True, energies=energies)


@port_tick.member(Plugged)
def _tick(
    s: Plugged, arrivals: Any, x: Vector, xd: Vector, p: PluggedParams
) -> tuple[Plugged, Any, Vector]:
    s = _measure(s, x, xd, p)
    tick = DeviceTick(s.x, s.xd, s.packet, s.silent, s.answered, s.applied, p.tick_s)
    law, answer = p.device(s.law, tick, p.values)
    return s._replace(law=law, answer=answer, answered=False), arrivals, answer.force


@port_applied.member(Plugged)
def _applied(s: Plugged, f: Vector, p: PluggedParams) -> Plugged:
    energy_j = p.tick_s * dot(f, s.xd)
    given, taken, sent_j, received_j = s.energies
    given, taken = given + max(energy_j, 0.0), taken + max(-energy_j, 0.0)
    return s._replace(applied=f, energies=(given, taken, sent_j, received_j))


@port_signals.member(Plugged)
def _signals(s: Plugged) -> tuple[Vector, Vector, Vector]:
    nothing = zero(s.x)
    return nothing, nothing, nothing


@port_energies.member(Plugged)
def _energies(s: Plugged, arrivals: Any, p: PluggedParams) -> Vector:
    given, taken, sent_j, received_j = s.energies
    of_port = (given, sent_j, received_j, taken) if p.waves else (given, given, taken, taken)
    return of_port + p.energies(s.law)


class Kept(NamedTuple):
    """What the law keeps of an avatar, and what it starts from whenever the user joins."""

    law: Any
    rest: Any


@released_brake.member(Kept)
def _released(s: Kept) -> Kept:
    return Kept(s.rest, s.rest)


class PluggedServerParams(NamedTuple):
    """The law and the parameters of each user; the object."""

    avatar: Callable[..., Any]
    values: tuple[Any, ...]
    energies: Callable[..., Vector]
    body: BodyLaw


@environment_step.member(PluggedServerParams)
def _step(p: PluggedServerParams, s: Environment, came: tuple[Any, ...]) -> Environment:
    avatars, body, lost_j = object_pushed(tuple(port.avatar for port in s.ports), s.body, p.body)
    ports = []
    for i in range(len(s.ports)):
        port, dropped_j = _met(s.ports[i], avatars[i], came[i], p.values[i], body, p)
        ports.append(port)
        lost_j += dropped_j
    return Environment(tuple(ports), body, s.dissipated_j + lost_j, s.unsettled)


def _met(
    s: UserPort, a: Avatar, came: Any, values: Any, body: Body, p: PluggedServerParams
) -> tuple[UserPort, float]:
    if not a.present:
        return s, 0.0
    h, position = p.body.period_s, plus(came.position, s.offset)
    step = AvatarStep(position, came.wave, came.extra, s.x_s, a.xd, a.f, a.contact, body, h)
    law, answer = p.avatar(s.brake.law, step, values)
    moved = answer.moved
    flow_j = h * dot(moved.f, moved.xd)
    u_j, v_j = s.u_j + max(flow_j, 0.0), s.v_j + max(-flow_j, 0.0)
    avatar = a._replace(xd=moved.xd, f=moved.f, contact=moved.contact)
    kept = s.brake._replace(law=law)
    s = UserPort(avatar, kept, s.offset, moved.x_s, answer.wave, u_j, v_j, -1.0, answer.extra)
    return s, moved.lost_j


@environment_energies.member(PluggedServerParams)
def _environment_energies(p: PluggedServerParams, s: Environment) -> Vector:
    sums = [p.energies(port.brake.law) for port in s.ports]
    accounts = tuple(sum(of_users) for of_users in zip(*sums, strict=True))
    return kinetic_j(s.body, p.body), potential_j(s), *accounts


port_shown.member(PluggedServerParams)(port_without_waves)
