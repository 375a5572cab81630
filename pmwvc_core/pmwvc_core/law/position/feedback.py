# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback on the returning wave, v_m - K_p e, and who pays for it; by default there is
none.

On the plain channel e = x_m - x_s - x_ref (``printed``, ``budgeted``) or its residual
(``integral``). ``printed`` pays for nothing and can generate energy; the others change v_m, and
shorten packets, as the energy tank allows (:mod:`.energy_tank`), which begins with ``lent_j``.

On the strict channel the node (:mod:`pmwvc_core.law.port.strict_master`) pays, beginning with E0.
A tick takes at most what is free, spread over ``SPREAD_S``. Between packets the avatar's position
follows a line, and the correction changes by at most ``QUICKEST``. In free motion e is the delay
of the link: it counts as far as the avatar feels a force, in full from ``FORCE_N`` on. A gain that
adapts grows by up to ``MOST`` as less is left of E0. Equations: docs/theory.md 17.8, 17.16.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.channel.constants import SPREAD_S
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.family import Family, accounts, opened, passed, same
from pmwvc_core.law.position.energy_tank import Tank, tank_down, tank_packet, tank_send, tank_up
from pmwvc_core.law.position.error import (
    FeedbackParams,
    PositionError,
    Posted,
    asked,
    error_packet,
    error_sent,
    error_taken,
    error_tick,
    is_news,
    is_same_avatar,
)
from pmwvc_core.law.vectors import Vector, minus, plus, scaled, shortened, squared
from pmwvc_core.law.wave.wave import affordable, wave_u

QUICKEST = 2.0  # [sqrt(W)/s] of the correction: 14 N/s behind 25 N s/m
MOST = 2.0  # times the gain, with less left than a share of the loan
FULL, LEAST = 0.75, 0.25  # shares of the loan: the gain itself is used above, MOST times it below
FORCE_N = 0.05  # at the avatar: the whole error counts; below it the square of the ratio of it

# (s, packet, there, p) -> s: the newest, with the avatar's position; whether the server is there
position_in = Family("position_in", same)
# (s, v, x, free_j, waiting, p) -> (s, v): free_j of the node, and the integral that the playout
# holds [sqrt(W) s], on the strict channel
position_down = Family("position_down", passed)
position_up = Family("position_up", same)  # (s, u, f, xd, p) -> s: the wave of a tick that goes on
position_send = Family("position_send", passed)  # (s, wave, number, frame_s, p) -> (s, wave)


class Budgeted(NamedTuple):
    """Feedback paid out of a tank, which pays whatever is asked as published."""

    error: PositionError
    tank: Tank


@position_in.member(Budgeted)
def _budgeted_packet(s: Budgeted, packet: Packet, there: bool, p: FeedbackParams) -> Budgeted:
    return Budgeted(error_packet(s.error, packet, there, p), tank_packet(s.tank, packet, p))


@position_down.member(Budgeted)
def _budgeted_down(
    s: Budgeted, v: Vector, x: Vector, free_j: float, waiting: Vector, p: FeedbackParams
) -> tuple[Budgeted, Vector]:
    down = plus(s.error.wave, scaled(s.error.v, p.hold_s))  # the newest packet, the hold's wave
    error, e = error_tick(s.error, x, s.error.x, v, down, p)
    tank, change = tank_down(s.tank, x, v, asked(error, e, p), error.there, p)
    return Budgeted(error, tank), plus(v, change) if error.there else v


@position_up.member(Budgeted)
def _budgeted_up(s: Budgeted, u: Vector, f: Vector, xd: Vector, p: FeedbackParams) -> Budgeted:
    return Budgeted(error_taken(s.error, u, p.tick_s), tank_up(s.tank, u, f, xd, p.tick_s))


@position_send.member(Budgeted)
def _budgeted_send(
    s: Budgeted, wave: Vector, number: int, frame_s: float, p: FeedbackParams
) -> tuple[Budgeted, Vector]:
    tank, sent = tank_send(s.tank, wave, p)
    return Budgeted(error_sent(s.error, wave, sent, number, frame_s), tank), sent


@accounts.member(Budgeted)
def _budgeted_energies(s: Budgeted, p: FeedbackParams) -> Vector:
    return accounts(s.tank, p)


class OnStrict(NamedTuple):
    """Feedback paid out of the node; the position goes on a line from packet to packet."""

    error: PositionError
    x: Vector  # [m] of the avatar
    change: Vector  # of the wave [sqrt(W)]
    share: float  # of the error that counts, by the newest packet's force
    left_s: float  # until the line is there
    integral: Vector  # of the newest packet [sqrt(W) s]
    spent_j: float  # what it took so far, less what it brought


@position_in.member(OnStrict)
def _strict_packet(s: OnStrict, packet: Packet, there: bool, p: FeedbackParams) -> OnStrict:
    error, x, share, left_s = error_packet(s.error, packet, there, p), s.x, s.share, s.left_s
    if not is_news(s.error, packet):
        return s._replace(error=error)
    if is_same_avatar(s.error, packet):
        # as late as the waves of the ramp
        left_s = packet.period_s + 0.5 * (packet.period_s - p.tick_s)
        wave = scaled(minus(packet.integral, s.integral), 2.0)
        rest = wave_u(p.impedance, minus(packet.position, s.error.x), wave)
        lasted_s = (packet.number - s.error.number) * packet.period_s
        force = scaled(wave_u(p.impedance, rest, scaled(rest, 0.0)), 0.5 / lasted_s)
        share = min(squared(force) * FORCE_N**-2, 1.0)
    else:
        x = packet.position
    return OnStrict(error, x, s.change, share, left_s, packet.integral, s.spent_j)


@position_down.member(OnStrict)
def _strict_down(
    s: OnStrict, v: Vector, x: Vector, free_j: float, waiting: Vector, p: FeedbackParams
) -> tuple[OnStrict, Vector]:
    at, left_s = s.x, s.left_s
    if left_s > 0.0:
        ratio = min(p.tick_s / left_s, 1.0)
        at = plus(at, scaled(minus(s.error.x, at), ratio))
        left_s -= p.tick_s
    error, e = error_tick(s.error, x, at, v, waiting, p)
    wanted = asked(error, scaled(e, s.share if error.there else 0.0), p)
    if p.adapts and p.lent_j > 0.0:
        used = (FULL - free_j / p.lent_j) * (1.0 / (FULL - LEAST))
        wanted = scaled(wanted, 1.0 + (MOST - 1.0) * min(max(used, 0.0), 1.0))
    wanted = plus(s.change, shortened(minus(wanted, s.change), QUICKEST * p.tick_s))
    wanted, cost = affordable(v, wanted, max(free_j, 0.0) * (2.0 / SPREAD_S))
    spent_j = s.spent_j + cost * (0.5 * p.tick_s)
    return OnStrict(error, at, wanted, s.share, left_s, s.integral, spent_j), plus(v, wanted)


@position_up.member(OnStrict)
def _strict_up(s: OnStrict, u: Vector, f: Vector, xd: Vector, p: FeedbackParams) -> OnStrict:
    return s._replace(error=error_taken(s.error, u, p.tick_s))


@position_send.member(OnStrict)
def _strict_send(
    s: OnStrict, wave: Vector, number: int, frame_s: float, p: FeedbackParams
) -> tuple[OnStrict, Vector]:
    return s._replace(error=error_sent(s.error, wave, wave, number, frame_s)), wave


@accounts.member(OnStrict)
def _spent(s: OnStrict, p: FeedbackParams) -> Vector:
    return (s.spent_j,)


@opened.member(Budgeted, OnStrict)
def _opened(s: Any) -> Any:
    """Return the feedback before the first packet, its list made here."""
    return s._replace(error=s.error._replace(posted=[Posted(0, s.error.sent, 0.0)]))
