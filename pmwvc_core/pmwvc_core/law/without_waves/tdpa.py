# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Time-domain passivity observer and controller for a two-port with delay (Hannaford and Ryu 2002;
Ryu, Artigas and Preusche 2010).

The device sends its velocity, the server its contact force. Both ends count the flow at their
port, P = f . velocity against the link, and send E_in::

    E_in += max(P, 0) h,    E_out += max(-P, 0) h
    allowance = E_in of the other, as received, - E_out + what its controller has dissipated

Where the next step would overdraw it by dE, the controller dissipates dE, by a damper at the
device and by giving way at the avatar::

    F += a xd,   a = min(dE/(h |xd|^2), damping_max),        xd_s -= (dE/(h |f|^2)) f

At the device the work of a tick is counted when done, f_{k-1} . (x_k - x_{k-1}). The drift of the
avatar is made up by a share per step under the same observer (after Coelho et al. 2019).
"""

from typing import NamedTuple

from pmwvc_core.law.channel.packet import Sent
from pmwvc_core.law.family import accounts
from pmwvc_core.law.server.contacts import contact_force, contact_heat, offset_of, slid
from pmwvc_core.law.vectors import Vector, dot, minus, plus, scaled, squared, zero
from pmwvc_core.law.without_waves import ends
from pmwvc_core.law.without_waves.ends import AvatarAnswer, DeviceEnd, DeviceEndParams, Moved

LEAST = 1e-30  # [m^2/s^2] or [N^2]: a square below it is nothing to divide by


class Tdpa(NamedTuple):
    """The law at either end."""

    damping: float  # [N s/m] local one of the device
    damping_max: float  # [N s/m] of the controller's damper
    kept: float  # ratio of it that a tick leaves
    drift_share: float  # of the avatar's lag made up in a step


class Observer(NamedTuple):
    """The energy of one end of the link [J]."""

    in_j: float = 0.0
    out_j: float = 0.0
    dissipated_j: float = 0.0  # by the passivity controller
    allowance_j: float = 0.0  # what may still be given out
    received_j: float = 0.0


class TdpaEnd(NamedTuple):
    """Either end."""

    force: Vector  # as last received [N]; none at the avatar
    observer: Observer = Observer()
    damping: float = 0.0  # of the controller [N s/m]


def informed(s: Observer, received_j: float) -> Observer:
    """Take in what the other end has put in so far."""
    allowance_j = s.allowance_j + (received_j - s.received_j)
    return s._replace(allowance_j=allowance_j, received_j=received_j)


def overdraft_j(s: Observer, energy_j: float) -> float:
    """Return how much too much it would be to give out an energy (negative: take in)."""
    return max(max(energy_j, 0.0) - s.allowance_j, 0.0)


def observed(s: Observer, energy_j: float, dissipated_j: float, allowed_j: float) -> Observer:
    """Book what a step gave out (negative: took in), the dissipation of the controller left out of
    it, that, and how much of it may be given out again.
    """
    given_j = max(energy_j, 0.0)
    return Observer(
        s.in_j + max(-energy_j, 0.0), s.out_j + given_j, s.dissipated_j + dissipated_j,
        s.allowance_j - given_j + allowed_j, s.received_j,
    )  # fmt: skip


@ends.device_moved.member(TdpaEnd)
def _moved(s: TdpaEnd, was: DeviceEnd, x: Vector, xd: Vector, p: DeviceEndParams) -> TdpaEnd:
    """Book the work of the force held until here; the local damper is not the link's."""
    way = minus(x, was.x)
    drag = dot(was.xd, way)
    dissipated_j = s.damping * drag
    given_j = dissipated_j + p.law.damping * drag - dot(was.f, way)
    return s._replace(observer=observed(s.observer, given_j, dissipated_j, dissipated_j))


@ends.device_sends.member(TdpaEnd)
def _send(s: TdpaEnd, end: DeviceEnd, frame_s: float, p: DeviceEndParams) -> tuple[TdpaEnd, Sent]:
    return s, Sent(end.xd, end.x, s.observer.in_j, (), 0)


@ends.device_answer.member(TdpaEnd)
def _answer(s: TdpaEnd, end: DeviceEnd, came: ends.FromServer, p: DeviceEndParams) -> TdpaEnd:
    force = zero(came.wave) if came.silent else came.wave
    return s._replace(force=force, observer=informed(s.observer, came.received_j))


@ends.device_force.member(TdpaEnd)
def _force(s: TdpaEnd, end: DeviceEnd, p: DeviceEndParams) -> tuple[TdpaEnd, Vector]:
    """Return the force received and that of both dampers [N]."""
    xd, square, needed = end.xd, squared(end.xd), 0.0
    if square > LEAST:
        excess_j = overdraft_j(s.observer, -p.tick_s * dot(s.force, xd))
        needed = min(excess_j / (p.tick_s * square), p.law.damping_max)
    damping = max(needed, s.damping * p.law.kept)
    f = plus(s.force, scaled(xd, p.law.damping + damping))
    return s._replace(damping=damping), f


@accounts.member(TdpaEnd)
def _of_end(s: TdpaEnd, p: Tdpa) -> Vector:
    return s.observer.dissipated_j, s.observer.allowance_j


@ends.avatar_moved.member(Tdpa)
def _slid(p: Tdpa, s: TdpaEnd, step: ends.AvatarStep) -> tuple[TdpaEnd, AvatarAnswer]:
    """Arrive where the last step led, form the force, choose the velocity from here."""
    observer, body, h = informed(s.observer, step.received_j), step.body, step.period_s
    contact, lost_j = slid(step.contact, scaled(step.xd_s, h))
    x_s = plus(body.x, offset_of(contact))
    rate = minus(step.wave, body.xd)
    f = contact_force(contact, rate)
    excess_j = overdraft_j(observer, h * dot(f, step.wave))
    xd, size = plus(step.wave, scaled(minus(step.position, x_s), p.drift_share / h)), squared(f)
    if size > LEAST:  # the nearest velocity that gives out no more than may be
        xd = minus(xd, scaled(f, overdraft_j(observer, h * dot(f, xd)) / (h * size)))
    observer = observed(observer, h * dot(f, xd), excess_j, 0.0)
    lost_j += h * contact_heat(contact, rate)
    answer = AvatarAnswer(Moved(x_s, xd, f, contact, lost_j), f, (), observer.in_j)
    return s._replace(observer=observer), answer
