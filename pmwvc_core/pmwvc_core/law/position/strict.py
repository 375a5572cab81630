# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback on the strict channel: v_m - K_p e, paid out of the node.

The node (:mod:`pmwvc_core.law.port.strict_master`) begins with the energy lent, E0, and is
refilled to it before packets get more than they need. A tick takes at most what is free, spread
over ``SPREAD_S``. Between packets the avatar's position follows a line.

In free motion e is the delay of the link, x_m - x_s = v T, and must not be corrected: e counts as
far as the avatar feels a force, in full from ``FORCE_N`` on. The force follows from the packets
(the server's wave and the way of the avatar). A gain that adapts grows by up to ``MOST`` as less
is left of the loan, so that slow presses return what they took (17.17).

Equations: docs/theory.md 17.8, 17.16.
"""

from typing import NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.position import feedback
from pmwvc_core.law.position.energy_tank import SPREAD_S
from pmwvc_core.law.position.error import (
    PositionError,
    PositionParams,
    asked,
    error_packet,
    error_tick,
    is_news,
    is_same_avatar,
)
from pmwvc_core.law.position.plain import opened, seen_there, wave_sent, wave_taken
from pmwvc_core.law.vectors import Vector, minus, plus, scaled, squared
from pmwvc_core.law.wave.wave import affordable, wave_u

MOST = 2.0  # times the gain, with less left than a share of the loan
FULL, LEAST = 0.75, 0.25  # shares of the loan: the gain itself is used above, MOST times it below
FORCE_N = 0.05  # at the avatar: the whole error counts; below it the square of the ratio of it


class Line(NamedTuple):
    """The avatar's position and the share of the error that counts, on a line from packet to
    packet; and the integral of the newest one.
    """

    x: Vector  # [m]
    share: float
    under: float  # the share by the newest packet's force
    left_s: float  # until the line is there
    integral: Vector  # [sqrt(W) s]


class OnStrict(NamedTuple):
    """Feedback paid out of the node; what it took so far, less what it brought [J]."""

    error: PositionError
    line: Line
    spent_j: float


@feedback.position_packet.member(OnStrict)
def _packet(s: OnStrict, packet: Packet, p: PositionParams) -> OnStrict:
    if not is_news(s.error, packet):
        return s
    line, seen = s.line, s.error.seen
    x, under, left_s = line.x, line.under, line.left_s
    if is_same_avatar(s.error, packet):
        left_s = packet.period_s
        wave = scaled(minus(packet.integral, line.integral), 2.0)
        rest = wave_u(p.impedance, minus(packet.position, seen.x), wave)
        lasted_s = (packet.number - seen.number) * packet.period_s
        force = scaled(wave_u(p.impedance, rest, scaled(rest, 0.0)), 0.5 / lasted_s)
        under = min(squared(force) * FORCE_N**-2, 1.0)
    else:
        x = packet.position
    line = Line(x, line.share, under, left_s, packet.integral)
    return OnStrict(error_packet(s.error, packet, p), line, s.spent_j)


@feedback.position_down.member(OnStrict)
def _down(
    s: OnStrict, v: Vector, x: Vector, free_j: float, waiting: Vector, p: PositionParams
) -> tuple[OnStrict, Vector]:
    line = s.line
    if line.left_s > 0.0:
        ratio = min(p.tick_s / line.left_s, 1.0)
        at = plus(line.x, scaled(minus(s.error.seen.x, line.x), ratio))
        share = line.share + ratio * (line.under - line.share)
        line = Line(at, share, line.under, line.left_s - p.tick_s, line.integral)
    error, e = error_tick(s.error, x, line.x, v, waiting, p)
    if not error.there:
        return OnStrict(error, line, s.spent_j), v
    wanted = asked(error, scaled(e, line.share), p)
    if p.adapts and p.lent_j > 0.0:
        used = (FULL - free_j / p.lent_j) * (1.0 / (FULL - LEAST))
        wanted = scaled(wanted, 1.0 + (MOST - 1.0) * min(max(used, 0.0), 1.0))
    wanted, cost = affordable(v, wanted, max(free_j, 0.0) * (2.0 / SPREAD_S))
    return OnStrict(error, line, s.spent_j + cost * (0.5 * p.tick_s)), plus(v, wanted)


@feedback.position_lent.member(OnStrict)
def _lent(s: OnStrict, p: PositionParams) -> float:
    return p.lent_j


@feedback.position_energies.member(OnStrict)
def _energies(s: OnStrict) -> Vector:
    return (s.spent_j,)


feedback.position_there.member(OnStrict)(seen_there)
feedback.position_up.member(OnStrict)(wave_taken)
feedback.position_send.member(OnStrict)(wave_sent)
feedback.position_opened.member(OnStrict)(opened)
