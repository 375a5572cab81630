# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy that a master has taken in and not released, as far as it is free to be spent.

Energy that filter and hold may still release is reserved::

    free = [packets received - |v|^2 T_c/2 of the ticks - T_c (M-1)/4 |v|^2]     hold, per packet
         + [|u|^2 T_c/2 of the ticks - packets sent - tau |y|^2/2]            filter, at each send
         + min(0, F xd of the device less the energy into the link)           filters, limits
         + storage declared - spent - discarded

with v the wave of the hold, u the one from the device, y the filter's output, tau its group delay
less (M-1)/2 T_c. ``deficit_j`` is what the hold released without a packet and the tank did not
cover; later packets pay it first. A packet that the tank cannot pay for is shortened, and what is
*spent* is bounded by the measured work as well::

    storage + received + F xd - sent >= - deficit       at every packet, F xd of the waves
    spent <= storage + received + sum F_k (x_{k+1} - x_k) - sent, with the reserves above

Equations: docs/theory.md 3.3, 9.4, 9.5, 9.6, 9.7.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.channel.constants import SPREAD_S
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.family import accounts
from pmwvc_core.law.position.error import FeedbackParams
from pmwvc_core.law.vectors import Vector, dot, minus, scaled
from pmwvc_core.law.wave.wave import affordable, wave_j


class Tank(NamedTuple):
    """The account of one master, at first the storage declared; energies since the start [J]."""

    saved_j: float  # free but for parts and limits; below zero while reserves are not covered
    # What the next step refers to, at first zero:
    x: Vector
    f: Vector
    v: Vector
    y: Vector
    spent_j: float = 0.0  # less what came back
    deficit_j: float = 0.0  # given out by the hold, brought by no packet, paid by nothing saved
    discarded_j: float = 0.0  # was more than the account may hold
    played_j: float = 0.0  # of v
    taken_j: float = 0.0  # of u
    device_j: float = 0.0  # of F xd
    work_j: float = 0.0  # of the force held times the distance
    received_j: float = 0.0  # of packets
    of_hold_j: float = 0.0  # when last looked at, as of_u_j
    of_u_j: float = 0.0
    epoch: int = -1  # of the newest packet, as number and sum_j
    number: int = 0
    sum_j: float = 0.0


def _channel_j(s: Tank) -> float:
    """Return what the waves took in at the device [J]."""
    return s.taken_j - s.played_j - s.spent_j


def _lacking_j(s: Tank) -> float:
    """Return what parts and limits gave out more than they got [J], as a number below zero."""
    return min(s.device_j - _channel_j(s), 0.0)


def tank_free_j(s: Tank) -> float:
    """Return the energy that may be spent now [J]."""
    by_work = s.saved_j + s.discarded_j + (s.work_j - _channel_j(s))
    return max(min(s.saved_j + _lacking_j(s), by_work), 0.0)


@accounts.member(Tank)
def _energies(s: Tank, p: FeedbackParams) -> Vector:
    return s.spent_j, tank_free_j(s), s.discarded_j, s.deficit_j


def _saved(s: Tank, energy_j: float, most_j: float) -> Tank:
    """Put energy on the account; what is more than it may hold is gone."""
    saved_j = s.saved_j + energy_j
    held_j = min(saved_j, most_j)
    return s._replace(saved_j=held_j, discarded_j=s.discarded_j + (saved_j - held_j))


def tank_packet(s: Tank, packet: Packet, p: FeedbackParams) -> Tank:
    """Settle the frame that ends, then take the newest packet in."""
    of_hold_j = s.received_j - s.played_j - wave_j(s.v, p.hold_s)
    change_j = of_hold_j - s.of_hold_j
    gained_j, lost_j = max(change_j, 0.0), max(-change_j, 0.0)
    repaid_j = min(s.deficit_j, gained_j)
    drawn_j = min(max(s.saved_j, 0.0), lost_j)
    deficit_j = s.deficit_j + (lost_j - drawn_j) - repaid_j
    s = _saved(s, gained_j - repaid_j - drawn_j, p.most_j)
    epoch, number, sum_j, received_j = s.epoch, s.number, s.sum_j, s.received_j
    if packet.epoch != epoch or packet.number > number:
        if packet.epoch != epoch:
            sum_j = packet.energy_j - wave_j(packet.wave, packet.period_s)
        received_j += max(packet.energy_j - sum_j, 0.0)
        epoch, number, sum_j = packet.epoch, packet.number, packet.energy_j
    return s._replace(deficit_j=deficit_j, received_j=received_j, of_hold_j=of_hold_j,
                      epoch=epoch, number=number, sum_j=sum_j)  # fmt: skip


def tank_down(
    s: Tank, x: Vector, v: Vector, wanted: Vector, spends: bool, p: FeedbackParams
) -> tuple[Tank, Vector]:
    """Count the work of the force held until the device is at x [m], and the wave v that the hold
    gives out; return as much of a change wanted of it as can be paid for within 0.1 s [sqrt(W)].
    """
    work_j = s.work_j + dot(s.f, minus(x, s.x))
    s = s._replace(played_j=s.played_j + wave_j(v, p.tick_s), work_j=work_j, x=x, v=v)
    if not spends:
        return s, wanted
    power = tank_free_j(s) * (2.0 / SPREAD_S) if p.pays else math.inf
    wanted, cost = affordable(v, wanted, power)
    cost_j = cost * (0.5 * p.tick_s)
    return _saved(s._replace(spent_j=s.spent_j + cost_j), -cost_j, p.most_j), wanted


def tank_up(s: Tank, u: Vector, f: Vector, xd: Vector, h: float) -> Tank:
    """Note what came back in a tick [sqrt(W)], and the device's force and velocity."""
    taken_j, device_j = s.taken_j + wave_j(u, h), s.device_j + dot(f, xd) * h
    return s._replace(taken_j=taken_j, device_j=device_j, f=f)


def tank_send(s: Tank, y: Vector, p: FeedbackParams) -> tuple[Tank, Vector]:
    """Return the filter's output y, or as much of it as can be paid for [sqrt(W)]."""
    filter_s, sent = max(p.filter_s, 0.0), y
    before_j = s.taken_j - s.of_u_j + wave_j(s.y, filter_s)
    needed_j = wave_j(y, p.frame_s)
    allowed_j = max(s.saved_j + before_j + _lacking_j(s), 0.0)
    if p.pays and needed_j > allowed_j:
        sent = scaled(y, math.sqrt(min(allowed_j / needed_j, 1.0)))
        needed_j = allowed_j
    s = _saved(s, before_j - wave_j(y, filter_s) - needed_j, p.most_j)
    return s._replace(y=y, of_u_j=s.taken_j), sent
