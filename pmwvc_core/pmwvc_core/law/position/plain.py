# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback on the returning wave of the plain channel.

The wave changes by - K_p e (:mod:`.error`), with e = x_m - x_s - x_ref (``printed``,
``budgeted``) or what of it the waves on their way do not explain (``integral``). ``printed`` pays
for nothing: it can make energy. The others change v_m only as far as the energy tank of the master
pays for it (:mod:`.energy_tank`), and shorten a packet that it does not.

With K_p the link no longer is a spring: at rest v_m and e belong together only for e = 0, so that
the rendered stiffness is the environment's. No passive link without stored energy can do that
(K/M <= 4/tau^2, docs/theory.md, section 11): ``lent_j`` is what the paid forms hold at the start,
and the port is passive with this storage.
"""

from typing import NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.position.energy_tank import (
    Tank,
    resting_tank,
    tank_down,
    tank_free_j,
    tank_packet,
    tank_send,
    tank_up,
)
from pmwvc_core.law.position.error import (
    PositionError,
    PositionParams,
    asked,
    error_opened,
    error_packet,
    error_sent,
    error_taken,
    error_there,
    error_tick,
    is_news,
    resting_error,
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
from pmwvc_core.law.vectors import Vector, plus, scaled, squared


class Published(NamedTuple):
    """Feedback without regard to energy; what it spent [J]."""

    error: PositionError
    spent_j: float


class Budgeted(NamedTuple):
    """Feedback paid out of a tank."""

    error: PositionError
    tank: Tank


def resting_published(nothing: Vector) -> Published:
    """Return the feedback before the first packet."""
    return Published(resting_error(nothing), 0.0)


def resting_budgeted(nothing: Vector, p: PositionParams) -> Budgeted:
    """Return the feedback before the first packet."""
    return Budgeted(resting_error(nothing), resting_tank(nothing, p.lent_j))


def _error(
    s: PositionError, v: Vector, x: Vector, p: PositionParams
) -> tuple[PositionError, Vector]:
    """Return the error; what comes down is the newest packet, and the hold's wave before."""
    return error_tick(s, x, s.seen.x, v, plus(s.seen.wave, scaled(s.v, p.hold_s)), p)


@position_packet.member(Published)
def _published_packet(s: Published, packet: Packet, p: PositionParams) -> Published:
    return (
        Published(error_packet(s.error, packet, p), s.spent_j) if is_news(s.error, packet) else s
    )


@position_packet.member(Budgeted)
def _budgeted_packet(s: Budgeted, packet: Packet, p: PositionParams) -> Budgeted:
    error = error_packet(s.error, packet, p) if is_news(s.error, packet) else s.error
    return Budgeted(error, tank_packet(s.tank, packet, p))


@position_there.member(Published)
def _published_there(s: Published, there: bool) -> Published:
    return Published(error_there(s.error, there), s.spent_j)


@position_there.member(Budgeted)
def _budgeted_there(s: Budgeted, there: bool) -> Budgeted:
    return Budgeted(error_there(s.error, there), s.tank)


@position_down.member(Published)
def _published_down(
    s: Published, v: Vector, x: Vector, free_j: float, waiting: Vector, p: PositionParams
) -> tuple[Published, Vector]:
    error, e = _error(s.error, v, x, p)
    if not error.there:
        return Published(error, s.spent_j), v
    changed = plus(v, asked(error, e, p))
    more = squared(changed) - squared(v)
    return Published(error, s.spent_j + more * (0.5 * p.tick_s)), changed


@position_down.member(Budgeted)
def _budgeted_down(
    s: Budgeted, v: Vector, x: Vector, free_j: float, waiting: Vector, p: PositionParams
) -> tuple[Budgeted, Vector]:
    error, e = _error(s.error, v, x, p)
    tank, change = tank_down(s.tank, x, v, asked(error, e, p), error.there, p)
    return Budgeted(error, tank), plus(v, change) if error.there else v


@position_up.member(Published)
def _published_up(s: Published, u: Vector, f: Vector, xd: Vector, p: PositionParams) -> Published:
    return Published(error_taken(s.error, u, p.tick_s), s.spent_j)


@position_up.member(Budgeted)
def _budgeted_up(s: Budgeted, u: Vector, f: Vector, xd: Vector, p: PositionParams) -> Budgeted:
    return Budgeted(error_taken(s.error, u, p.tick_s), tank_up(s.tank, u, f, xd, p.tick_s))


@position_send.member(Published)
def _published_send(
    s: Published, wave: Vector, number: int, frame_s: float, p: PositionParams
) -> tuple[Published, Vector]:
    return Published(error_sent(s.error, wave, wave, number, frame_s), s.spent_j), wave


@position_send.member(Budgeted)
def _budgeted_send(
    s: Budgeted, wave: Vector, number: int, frame_s: float, p: PositionParams
) -> tuple[Budgeted, Vector]:
    tank, sent = tank_send(s.tank, wave, p)
    return Budgeted(error_sent(s.error, wave, sent, number, frame_s), tank), sent


@position_lent.member(Published)
def _published_lent(s: Published, p: PositionParams) -> float:
    return 0.0


@position_lent.member(Budgeted)
def _budgeted_lent(s: Budgeted, p: PositionParams) -> float:
    return 0.0


@position_energies.member(Published)
def _published_energies(s: Published) -> Vector:
    return (s.spent_j,)


@position_energies.member(Budgeted)
def _budgeted_energies(s: Budgeted) -> Vector:
    level = s.tank.level
    return level.spent_j, tank_free_j(s.tank), level.discarded_j, level.deficit_j


@position_opened.member(Published)
def _published_opened(s: Published) -> Published:
    return Published(error_opened(s.error), s.spent_j)


@position_opened.member(Budgeted)
def _budgeted_opened(s: Budgeted) -> Budgeted:
    return Budgeted(error_opened(s.error), s.tank)
