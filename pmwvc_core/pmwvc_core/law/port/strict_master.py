# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of the strict channel: displacement exact, energy as far as the hand gives it.

Per tick of length h, with F the force really applied and dx the motion really measured over it::

    v     of the playout, every tick
    F_m = b xd - sqrt(2b) v_m                  asked of the device
    u   = sqrt(2b) dx/h - v_m                  known when the tick is over;   U <- U + u h
                                               (u_m is its estimate, sqrt(2b) xd - v_m)
    node <- node + |v|^2 h/2 + F dx            what came in from both sides (dx: ``counts.moved``)

and per packet, for the mean wave w of its frame::

    paid  = all of the node but KEPT_J, and of that what w needs, |w|^2 T/2
            (never what the brake stores: the hand can have it back)
    J <- J + paid,   node <- node - paid

So the energy J sent never exceeds what channel and hand gave, whatever safety limits, velocity
estimate, encoder, port filters or a late tick made of force and wave: they delay the payment, not
the displacement U + V = sqrt(2b) x. Where a force that went on pushing out took the node itself
below ``-LIMIT_J``, v waits until the hand has paid: the port is a damper. The packet carries w: no
anti-aliasing filter, which passivity does not need here.

Behind an encoder whose differences are the velocity, packets always lack some energy. Their
deficit counts twice (``TWICE``), since to make the displacement up takes as much again, and the
hand pays it by moving: F_m gets up to ``MORE`` of b xd on top, all of it from ``MUCH_J`` on.

Where one of the playouts is short of energy, after outages or with a lag that has grown, the other
one's surplus goes to it, and the hand pays likewise, through ``ASKED`` of b xd: packets take it to
the playout of the server, which returns what it does not need. Motion that no force paid for, as
that of a device that was silent, is undelivered there, too: up to all of b xd from ``MUCH`` on.

Equations: docs/theory.md 17.4, 17.5, 17.10, 17.23.
"""

import math
from typing import Any

from pmwvc_core.law.channel.arrivals import StrictArrivals
from pmwvc_core.law.channel.packet import Packet, Sent
from pmwvc_core.law.channel.playout import (
    Playout,
    free_j,
    is_short,
    play,
    release,
    spared,
    take_back,
    waiting,
)
from pmwvc_core.law.port.counts import Counts, counts, may_count, resting_counts, rough_count
from pmwvc_core.law.port.master import (
    port_answer,
    port_applied,
    port_energies,
    port_measure,
    port_opened,
    port_packet,
    port_send,
    port_signals,
    port_tick,
)
from pmwvc_core.law.port.port_filters import answered, filters_energies, filters_up, force_velocity
from pmwvc_core.law.port.sensing import known_motion
from pmwvc_core.law.port.strict_state import (
    Node,
    StrictEnergies,
    StrictMaster,
    StrictMasterParams,
    Under,
)
from pmwvc_core.law.position.feedback import (
    position_down,
    position_energies,
    position_lent,
    position_opened,
    position_packet,
    position_send,
    position_there,
    position_up,
)
from pmwvc_core.law.vectors import Vector, dot, each, length, plus, scaled, squared, zero
from pmwvc_core.law.wave.wave import damper, wave_force, wave_u

KEPT_J = 1e-4  # at the node where a packet does not need it: a tick is paid for when it is over
LIMIT_J = 2e-3
MORE = 0.3  # of the damper b, while packets lack energy
ASKED = 0.2  # likewise, while a playout is short of energy
MUCH = 0.03  # [sqrt(W) s] that packets were not paid for: all of b is asked for
MUCH_J = 1e-3
MOST_DEFICIT_J = 0.01
TWICE = 2.0
WITHHELD = 1.0  # of b q^2/h: so far ahead of the true work the one counted may be at first
SPARED_J = 1e-3  # left to the playout for catching up when the node takes what is free there


def _with_playout(a: StrictArrivals, playout: Playout) -> StrictArrivals:
    return StrictArrivals(a.silence, playout, a.counting, a.position, a.wanted)


@port_measure.member(StrictMaster)
def _settle(s: StrictMaster, x: Vector, xd: Vector, p: StrictMasterParams) -> StrictMaster:
    """Account for the tick that ended with this motion; once."""
    x, xd = known_motion(x, xd, s.x)
    under, h, node, e = s.under, p.tick_s, s.node, s.energies
    if under.settled:
        if under.begun:
            return s
        return StrictMaster(
            node, s.filters, s.position, s.waves, x, xd, each(resting_counts, (x,)), s.integral,
            under, s.unpaid, s.asks, e,
        )  # fmt: skip
    after = each(counts, (s.counts, x, xd), h)
    tracked, xd = each(_state, (after,)), each(_velocity, (after,))
    u = wave_u(p.impedance, scaled(each(_moved_wave, (after,)), 1.0 / h), s.waves[2])
    filters, u = filters_up(s.filters, u, p.filters)
    position = position_up(s.position, u, under.f, xd, p.position)
    worked = dot(under.f, each(_moved_force, (after,)))
    node_j = node.node_j + squared(under.v) * (0.5 * h) + worked
    due_j = node.due_j + squared(u) * (0.5 * h)
    node = Node(node_j, node.deficit_j, node.withheld_j, due_j)
    return StrictMaster(
        node, filters, position, (s.waves[0], u, s.waves[2]), x, xd, tracked,
        plus(s.integral, scaled(u, h)), Under(under.v, under.f, True, True), s.unpaid, s.asks, e,
    )  # fmt: skip


def _state(counted: Any) -> Counts:
    return counted[0]


def _velocity(counted: Any) -> float:
    return counted[1].xd


def _moved_wave(counted: Any) -> float:
    return counted[1].dx


def _moved_force(counted: Any) -> float:
    return counted[1].moved


@port_send.member(StrictMaster)
def _send(
    s: StrictMaster, a: StrictArrivals, frame_s: float, number: int, held_j: float,
    p: StrictMasterParams,
) -> tuple[StrictMaster, StrictArrivals, Sent]:  # fmt: skip
    """Send the mean wave of the frame [sqrt(W)], and pay for it."""
    playout, node, e, unpaid = a.playout, s.node, s.energies, s.unpaid
    wave = scaled(s.integral, 1.0 / frame_s)
    needed, lent = squared(wave) * (0.5 * frame_s), position_lent(s.position, p.position)
    node_j, withheld_j, counting = node.node_j, node.withheld_j, False
    for i in range(len(s.counts)):
        counting = counting or may_count(s.counts[i])
    if counting:
        rough = each(rough_count, (s.counts,))
        withheld_j = dot(damper(p.impedance, rough), rough) * (WITHHELD / p.tick_s)
        node_j += node.withheld_j - withheld_j
    position, wave = position_send(s.position, wave, number, frame_s, p.position)
    kept = KEPT_J + lent
    if p.lends:
        playout, released_j = release(playout, max(kept - node_j, 0.0), SPARED_J)
        node_j += released_j
    playout, passed_j = spared(playout, frame_s, s.asks[0])
    node_j += passed_j
    own = node_j - held_j  # what the hand can have back is not paid out
    paid = max(min(own, needed), own - kept)
    if counting:
        paid = max(paid, min(own - lent, needed + node.deficit_j))
    paid = max(paid, 0.0)
    if paid < needed and withheld_j <= 0.0:  # not for its rough counts
        unpaid += (1.0 - math.sqrt(paid / needed)) * length(wave) * frame_s
    deficit_j = node.deficit_j
    if counting:
        short = needed - paid
        deficit_j += short + (TWICE - 1.0) * max(short, 0.0)
        deficit_j = min(max(deficit_j, 0.0), MOST_DEFICIT_J) if withheld_j > 0.0 else 0.0
    energies = StrictEnergies(e.u_m, e.u_tx + paid, e.v_m)
    s = StrictMaster(
        Node(node_j - paid, deficit_j, withheld_j, 0.0), s.filters, position, s.waves, s.x, s.xd,
        s.counts, zero(s.integral), s.under, unpaid, s.asks, energies,
    )  # fmt: skip
    return s, _with_playout(a, playout), Sent(wave, s.x, energies.u_tx, ())


@port_packet.member(StrictMaster)
def _packet(
    s: StrictMaster, a: StrictArrivals, packet: Packet, p: StrictMasterParams
) -> StrictMaster:
    """Note the avatar's position, and what the server lacks; the wave is the playout's."""
    unpaid = 0.0 if s.asks[0] and not packet.short else s.unpaid
    position = position_packet(s.position, packet, p.position)
    return StrictMaster(
        s.node, s.filters, position, s.waves, s.x, s.xd, s.counts, s.integral, s.under, unpaid,
        (packet.short, is_short(a.playout)), s.energies,
    )  # fmt: skip


@port_answer.member(StrictMaster)
def _answer(
    s: StrictMaster, wave: Vector, silent: bool, frame_s: float, p: StrictMasterParams
) -> StrictMaster:
    position = position_there(s.position, not silent)
    return StrictMaster(
        s.node, s.filters, position, s.waves, s.x, s.xd, s.counts, s.integral, s.under, s.unpaid,
        s.asks, s.energies,
    )  # fmt: skip


@port_tick.member(StrictMaster)
def _tick(
    s: StrictMaster, a: StrictArrivals, x: Vector, xd: Vector, p: StrictMasterParams
) -> tuple[StrictMaster, StrictArrivals, Vector]:
    """Return the force wanted for the tick that starts with this motion [N]."""
    s = _settle(s, x, xd, p)
    node, b, x, xd = s.node, p.impedance, s.x, s.xd
    playout, v = play(a.playout, p.tick_s, p.playout)
    if node.node_j < 0.0:
        # What is free in the playout goes to the node; where it still owes too much, v waits.
        playout, released_j = release(playout, -node.node_j, 0.0)
        node = Node(node.node_j + released_j, node.deficit_j, node.withheld_j, node.due_j)
        if node.node_j < -LIMIT_J - node.withheld_j:
            playout, v = take_back(playout, v, p.tick_s), zero(v)
    free_j = node.node_j - node.due_j
    position, w = position_down(s.position, v, x, free_j, waiting(playout), p.position)
    filters, v_m = answered(s.filters, w, x, xd, p.filters, b)
    u_m = wave_u(b, xd, v_m)
    filters, for_force = force_velocity(filters, xd, p.filters, b)
    f_m = wave_force(b, for_force, v_m)
    more = min(node.deficit_j * (MORE / MUCH_J), MORE) if node.deficit_j > 0.0 else 0.0
    if s.asks[0] or s.asks[1]:
        more += min(max(s.unpaid * (1.0 / MUCH), ASKED), 1.0)
    if more > 0.0:
        f_m = plus(f_m, scaled(damper(b, xd), more))
    s = StrictMaster(
        node, filters, position, (u_m, s.waves[1], v_m), x, xd, s.counts, s.integral,
        Under(v, s.under.f, False, s.under.begun), s.unpaid, s.asks, s.energies,
    )  # fmt: skip
    return s, _with_playout(a, playout), f_m


@port_applied.member(StrictMaster)
def _applied(s: StrictMaster, f: Vector, p: StrictMasterParams) -> StrictMaster:
    """Note the force that was let through [N]; what it cost is known when the tick is over."""
    e, half_s = s.energies, 0.5 * p.tick_s
    u_m = e.u_m + squared(s.waves[0]) * half_s
    energies = StrictEnergies(u_m, e.u_tx, e.v_m + squared(s.waves[2]) * half_s)
    return StrictMaster(
        s.node, s.filters, s.position, s.waves, s.x, s.xd, s.counts, s.integral,
        Under(s.under.v, f, False, s.under.begun), s.unpaid, s.asks, energies,
    )  # fmt: skip


@port_signals.member(StrictMaster)
def _signals(s: StrictMaster) -> tuple[Vector, Vector, Vector]:
    return s.waves


@port_energies.member(StrictMaster)
def _energies(s: StrictMaster, a: StrictArrivals, p: StrictMasterParams) -> Vector:
    e, m = s.energies, a.playout.moved
    own = (
        e.u_m, e.u_tx, m.received_j, e.v_m, s.node.node_j, m.given_j, m.released_j,
        free_j(a.playout), m.discarded_j,
    )  # fmt: skip
    others = filters_energies(s.filters, p.filters) + position_energies(s.position)
    return own + others


@port_opened.member(StrictMaster)
def _opened(s: StrictMaster) -> StrictMaster:
    return StrictMaster(
        s.node, s.filters, position_opened(s.position), s.waves, s.x, s.xd, s.counts, s.integral,
        s.under, s.unpaid, s.asks, s.energies,
    )  # fmt: skip
