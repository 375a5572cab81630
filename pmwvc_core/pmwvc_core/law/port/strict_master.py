# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of the strict channel: exact displacement, paid for by the hand.

Per tick of length h, with F the force applied and dx the motion measured over it::

    F_m = r (b xd - sqrt(2b) v_m)              v_m from the playout, every tick
    u   = sqrt(2b) dx/h - v_m                  once the tick is over;   U <- U + u h
    node <- node + r |v|^2 h/2 + F dx          energy in from both sides (dx: ``counts.moved``)

with r of :mod:`pmwvc_core.law.wave.following`, and per packet, which carries the mean wave w of
its frame without an anti-aliasing filter::

    paid  = all of the node but KEPT_J, and of that what w needs, r |w|^2 T/2
            (never what the brake stores)
    J <- J + paid,   node <- node - paid

Below ``-LIMIT_J`` at the node v is withheld: the port is a
damper. The surplus of one playout goes to the other.

The hand pays for what packets lack through additional damping: up to ``MORE`` of b xd for a
deficit (counted ``TWICE``) behind an encoder, ``ASKED`` while a playout is short, and all of b xd
from ``MUCH`` of unpaid displacement on; it comes and goes within ``MEND_S``.
Equations: docs/theory.md 17.4, 17.5, 17.10, 17.23.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.channel.arrivals import StrictArrivals, is_short, release, spared
from pmwvc_core.law.channel.constants import FEW, MEND_S
from pmwvc_core.law.channel.packet import Packet, Sent
from pmwvc_core.law.channel.playout import PlayoutParams, free_j, play, ramped, take_back, waiting
from pmwvc_core.law.family import accounts, opened
from pmwvc_core.law.port import master
from pmwvc_core.law.port.counts import LEAST_M, Counts, counts, resting_counts, rough_count
from pmwvc_core.law.port.master import known_motion, opened_port
from pmwvc_core.law.port.port_filters import answered, filters_up
from pmwvc_core.law.position.feedback import position_down, position_in, position_send, position_up
from pmwvc_core.law.vectors import Vector, columns, dot, each, length, plus, scaled, zero
from pmwvc_core.law.wave.following import ratio_of
from pmwvc_core.law.wave.wave import damper, wave_force, wave_j, wave_u

KEPT_J = 1e-4  # at the node where a packet does not need it: a tick is paid for when it is over
LIMIT_J, MUCH_J, MOST_DEFICIT_J = 2e-3, 1e-3, 0.01
MORE = 0.3  # of the damper b, while packets lack energy
ASKED = 0.2  # likewise, while a playout is short of energy
MUCH = 0.03  # [sqrt(W) s] that packets were not paid for: all of b is asked for
TWICE = 2.0
WITHHELD = 1.0  # of b q^2/h: so far ahead of the true work the one counted may be at first
SPARED_J = 1e-3  # left to the playout for catching up when the node takes what is free there


class StrictMaster(NamedTuple):
    """The wave port of a device on the strict channel; energies [J], of waves since the start."""

    node_j: float  # came in from both sides and is not paid to a packet yet
    deficit_j: float  # packets needed it and have not been paid with it yet
    withheld_j: float  # for rough counts
    due_j: float  # what the next packet needs at most, with position feedback
    filters: Any
    position: Any
    waves: tuple[Vector, Vector, Vector]  # u_m, u after the filters, v_m [sqrt(W)]
    x: Vector  # [m] last good one
    xd: Vector  # [m/s] for the force
    counts: tuple[Counts, ...]  # of every axis
    integral: Vector  # of u since the frame began [sqrt(W) s]
    v: Vector  # of the playout, in the tick under way [sqrt(W)]
    w: Vector  # likewise, after position feedback and filters: v_m over sqrt(r)
    target: float  # r of the newest packet
    more: float  # additional damping, over b
    f: Vector  # applied in it [N]
    settled: bool  # the tick is over and accounted for
    begun: bool  # a tick ever was
    raised: float  # r
    unpaid: float  # integral sent without its energy while the server is short [sqrt(W) s]
    wanted: bool  # energy is, at the other end
    short: bool  # it is, here
    u_m_j: float
    u_tx_j: float
    v_m_j: float


class StrictMasterParams(NamedTuple):
    """Impedance, tick [s], and the parameters of the parts."""

    impedance: Any
    tick_s: float
    filters: Any
    position: Any
    lends: bool  # whether the position feedback borrows from the node
    lent_j: float  # what the node begins with for it
    most: float  # n, the largest r
    playout: PlayoutParams


@master.port_measure.member(StrictMaster)
def _settle(s: StrictMaster, x: Vector, xd: Vector, p: StrictMasterParams) -> StrictMaster:
    """Account for the tick that ended with this motion; once."""
    x, xd = known_motion(x, xd, s.x)
    h = p.tick_s
    if s.settled:
        if s.begun:
            return s
        return s._replace(x=x, xd=xd, counts=each(resting_counts, (x,)))
    tracked, steps = columns(each(counts, (s.counts, x, xd), h))
    dx, moved, xd = columns(steps)
    u, raised = wave_u(p.impedance, scaled(dx, 1.0 / h), s.w), s.raised
    filters, u = filters_up(s.filters, u, p.filters)
    position = position_up(s.position, u, s.f, xd, p.position)
    node_j = s.node_j + raised * wave_j(s.v, h) + dot(s.f, moved)
    waves = s.waves[0], scaled(u, math.sqrt(raised)), s.waves[2]
    return s._replace(
        node_j=node_j, due_j=s.due_j + raised * wave_j(u, h),
        filters=filters, position=position, waves=waves, x=x, xd=xd,
        counts=tracked, integral=plus(s.integral, scaled(u, h)), settled=True, begun=True,
    )  # fmt: skip


@master.port_send.member(StrictMaster)
def _send(
    s: StrictMaster, a: StrictArrivals, frame_s: float, number: int, held_j: float,
    p: StrictMasterParams,
) -> tuple[StrictMaster, StrictArrivals, Sent]:  # fmt: skip
    """Send the mean wave of the frame [sqrt(W)], and pay for it."""
    playout, unpaid, deficit_j = a.playout, s.unpaid, s.deficit_j
    wave = scaled(s.integral, 1.0 / frame_s)
    needed, kept = s.raised * wave_j(wave, frame_s), KEPT_J + p.lent_j
    node_j, withheld_j, counting = s.node_j, s.withheld_j, False
    for i in range(len(s.counts)):
        counting = counting or s.counts[i].step_m >= LEAST_M
    if counting:
        rough = each(rough_count, (s.counts,))
        withheld_j = dot(damper(p.impedance, rough), rough) * (s.raised * WITHHELD / p.tick_s)
        node_j += s.withheld_j - withheld_j
    position, wave = position_send(s.position, wave, number, frame_s, p.position)
    if p.lends:
        playout, released_j = release(playout, max(kept - node_j, 0.0), SPARED_J)
        node_j += released_j
    beyond_j = min(p.playout.keep_j, 0.0) if unpaid > FEW else 0.0
    playout, passed_j = spared(playout, frame_s, s.wanted, beyond_j, p.playout)
    node_j += passed_j
    own = node_j - held_j  # what the hand can have back is not paid out
    paid = max(min(own, needed), own - kept)
    if counting:
        paid = max(paid, min(own - p.lent_j, needed + deficit_j))
    paid = max(paid, 0.0)
    if paid < needed and withheld_j <= 0.0:  # not for its rough counts
        unpaid += (1.0 - math.sqrt(paid / needed)) * length(wave) * frame_s
    if counting:
        short = needed - paid
        deficit_j += short + (TWICE - 1.0) * max(short, 0.0)
        deficit_j = min(max(deficit_j, 0.0), MOST_DEFICIT_J) if withheld_j > 0.0 else 0.0
    s = s._replace(
        node_j=node_j - paid, deficit_j=deficit_j, withheld_j=withheld_j, due_j=0.0,
        position=position, integral=zero(s.integral), unpaid=unpaid, u_tx_j=s.u_tx_j + paid,
    )  # fmt: skip
    return s, a._replace(playout=playout), Sent(wave, s.x, s.u_tx_j, (), 0)


@master.port_answer.member(StrictMaster)
def _answer(
    s: StrictMaster, a: StrictArrivals, packet: Packet, wave: Vector, silent: bool,
    frame_s: float, p: StrictMasterParams,
) -> StrictMaster:  # fmt: skip
    """Note the avatar's position, and what the server lacks; the wave is the playout's."""
    if packet.number == 0:
        return s
    unpaid = 0.0 if s.wanted and not packet.short else s.unpaid
    position = position_in(s.position, packet, not silent, p.position)
    short, target = is_short(a.playout, p.playout), ratio_of(packet.level, p.most)
    return s._replace(
        position=position, unpaid=unpaid, wanted=packet.short, short=short, target=target,
    )  # fmt: skip


@master.port_tick.member(StrictMaster)
def _tick(
    s: StrictMaster, a: StrictArrivals, x: Vector, xd: Vector, p: StrictMasterParams
) -> tuple[StrictMaster, StrictArrivals, Vector]:
    """Return the force wanted for the tick that starts with this motion [N]."""
    s = _settle(s, x, xd, p)
    node_j, b, x, xd = s.node_j, p.impedance, s.x, s.xd
    steps = max(round(a.counting.least_s / p.tick_s), 1)
    raised = s.raised + (s.target - s.raised) / steps
    playout = ramped(a.playout, steps)._replace(raised=raised)
    playout, v = play(playout, p.tick_s, p.playout)
    if node_j < 0.0:
        # What is free in the playout goes to the node; where it still owes too much, v waits.
        playout, released_j = release(playout, -node_j, 0.0)
        node_j += released_j
        if node_j < -LIMIT_J - s.withheld_j:
            playout, v = take_back(playout, v, p.tick_s), zero(v)
    spare_j = node_j - s.due_j
    position, w = position_down(s.position, v, x, spare_j, waiting(playout), p.position)
    filters, v_m, for_force = answered(s.filters, w, x, xd, p.filters, b)
    u_m = wave_u(b, xd, v_m)
    f_m, root = scaled(wave_force(b, for_force, v_m), raised), math.sqrt(raised)
    more = min(s.deficit_j * (MORE / MUCH_J), MORE) if s.deficit_j > 0.0 else 0.0
    if s.wanted or s.short:
        more += min(max(s.unpaid * (1.0 / MUCH), ASKED), 1.0)
    more = s.more + (more - s.more) * min(p.tick_s / MEND_S, 1.0)
    if more > 0.0:
        f_m = plus(f_m, scaled(damper(b, xd), more))
    s = s._replace(
        node_j=node_j, filters=filters, position=position, v=v, w=v_m,
        waves=(scaled(u_m, root), s.waves[1], scaled(v_m, root)), raised=raised, more=more,
        settled=False,
    )  # fmt: skip
    return s, a._replace(playout=playout), f_m


@master.port_passed.member(StrictMaster)
def _applied(s: StrictMaster, f: Vector, p: StrictMasterParams) -> StrictMaster:
    """Note the force that was let through [N]; what it cost is known when the tick is over."""
    u_m, _, v_m = s.waves
    u_m_j, v_m_j = s.u_m_j + wave_j(u_m, p.tick_s), s.v_m_j + wave_j(v_m, p.tick_s)
    return s._replace(f=f, settled=False, u_m_j=u_m_j, v_m_j=v_m_j)


@master.port_energies.member(StrictMaster)
def _energies(s: StrictMaster, a: StrictArrivals, p: StrictMasterParams) -> Vector:
    m = a.playout.moved
    own = (
        s.u_m_j, s.u_tx_j, m.received_j, s.v_m_j, s.node_j, m.given_j, m.released_j,
        free_j(a.playout), m.discarded_j,
    )  # fmt: skip
    return own + accounts(s.filters, p.filters) + accounts(s.position, p.position)


opened.member(StrictMaster)(opened_port)
