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
from pmwvc_core.law.family import accounts
from pmwvc_core.law.safety.brakes import released_brake
from pmwvc_core.law.vectors import Vector, squared, zero
from pmwvc_core.law.without_waves import ends
from pmwvc_core.law.without_waves.ends import (
    AvatarAnswer,
    AvatarStep,
    DeviceEnd,
    DeviceEndParams,
    FromServer,
    Moved,
    avatar_moved,
    placed_avatar,
    pulled_avatar,
)

__all__ = ["AvatarAnswer", "AvatarStep", "Moved", "placed_avatar", "pulled_avatar"]  # for plug-ins


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


class PluggedLaw(NamedTuple):
    """The laws of both ends and their parameters; whether packets carry waves."""

    device: Callable[..., Any]
    avatar: Callable[..., Any] | None
    values: Any
    energies: Callable[..., Vector]
    waves: bool


class Plugged(NamedTuple):
    """The law of a device's end."""

    law: Any
    packet: Packet
    answer: DeviceAnswer
    silent: bool = False
    answered: bool = False
    sent_j: float = 0.0  # by waves, and received by them
    received_j: float = 0.0


@ends.device_sends.member(Plugged)
def _send(s: Plugged, end: DeviceEnd, frame_s: float, p: DeviceEndParams) -> tuple[Plugged, Sent]:
    wave, sent_j = s.answer.wave, s.sent_j + squared(s.answer.wave) * (0.5 * frame_s)
    return s._replace(sent_j=sent_j), Sent(wave, end.x, -1.0, s.answer.extra, 0)


@ends.device_answer.member(Plugged)
def _answer(s: Plugged, end: DeviceEnd, came: FromServer, p: DeviceEndParams) -> Plugged:
    wave = zero(came.wave) if came.silent else came.wave
    received_j = s.received_j + squared(wave) * (0.5 * came.frame_s)
    packet = (came.packet if came.packet.number > 0 else s.packet)._replace(wave=wave)
    return s._replace(packet=packet, silent=came.silent, answered=True, received_j=received_j)


@ends.device_force.member(Plugged)
def _force(s: Plugged, end: DeviceEnd, p: DeviceEndParams) -> tuple[Plugged, Vector]:
    tick = DeviceTick(end.x, end.xd, s.packet, s.silent, s.answered, end.f, p.tick_s)
    law, answer = p.law.device(s.law, tick, p.law.values)
    return s._replace(law=law, answer=answer, answered=False), answer.force


@ends.device_passed_j.member(Plugged)
def _passed_j(s: Plugged, given_j: float, taken_j: float, p: PluggedLaw) -> Vector:
    sent_j, received_j = (s.sent_j, s.received_j) if p.waves else (given_j, taken_j)
    return given_j, sent_j, received_j, taken_j


class Kept(NamedTuple):
    """What the law keeps of an avatar, and what it starts from whenever the user joins."""

    law: Any
    rest: Any


@avatar_moved.member(PluggedLaw)
def _moved(p: PluggedLaw, kept: Kept, step: AvatarStep) -> tuple[Kept, AvatarAnswer]:
    assert p.avatar is not None  # else users meet the environment behind wave ports
    law, answer = p.avatar(kept.law, step, p.values)
    return kept._replace(law=law), answer


@accounts.member(Plugged, Kept)
def _energies(s: Any, p: PluggedLaw) -> Vector:
    return p.energies(s.law)


released_brake.member(Kept)(lambda s: Kept(s.rest, s.rest))
