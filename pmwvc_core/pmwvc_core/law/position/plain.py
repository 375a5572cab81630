# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback on the returning wave of the plain channel.

The wave changes by - K_p e (:mod:`.error`), with e = x_m - x_s - x_ref (``printed``,
``budgeted``) or its residual (``integral``). ``printed`` pays for nothing and can generate energy;
the others change v_m, and shorten packets, as the energy tank allows (:mod:`.energy_tank`). At
rest the rendered stiffness is the environment's, which takes stored energy (K/M <= 4/tau^2 without
it, docs/theory.md, section 11): ``lent_j`` at the start.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.position import feedback
from pmwvc_core.law.position.energy_tank import (
    Tank,
    tank_down,
    tank_free_j,
    tank_packet,
    tank_send,
    tank_up,
)
from pmwvc_core.law.position.error import (
    PositionError,
    PositionParams,
    Posted,
    asked,
    error_packet,
    error_sent,
    error_taken,
    error_tick,
    is_news,
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


def _error(
    s: PositionError, v: Vector, x: Vector, p: PositionParams
) -> tuple[PositionError, Vector]:
    """Return the error; what comes down is the newest packet, and the hold's wave before."""
    return error_tick(s, x, s.seen.x, v, plus(s.seen.wave, scaled(s.v, p.hold_s)), p)


@feedback.position_packet.member(Published)
def _published_packet(s: Published, packet: Packet, p: PositionParams) -> Published:
    if not is_news(s.error, packet):
        return s
    return s._replace(error=error_packet(s.error, packet, p))


@feedback.position_packet.member(Budgeted)
def _budgeted_packet(s: Budgeted, packet: Packet, p: PositionParams) -> Budgeted:
    error = error_packet(s.error, packet, p) if is_news(s.error, packet) else s.error
    return Budgeted(error, tank_packet(s.tank, packet, p))


@feedback.position_down.member(Published)
def _published_down(
    s: Published, v: Vector, x: Vector, free_j: float, waiting: Vector, p: PositionParams
) -> tuple[Published, Vector]:
    error, e = _error(s.error, v, x, p)
    if not error.there:
        return s._replace(error=error), v
    changed = plus(v, asked(error, e, p))
    more = squared(changed) - squared(v)
    return Published(error, s.spent_j + more * (0.5 * p.tick_s)), changed


@feedback.position_down.member(Budgeted)
def _budgeted_down(
    s: Budgeted, v: Vector, x: Vector, free_j: float, waiting: Vector, p: PositionParams
) -> tuple[Budgeted, Vector]:
    error, e = _error(s.error, v, x, p)
    tank, change = tank_down(s.tank, x, v, asked(error, e, p), error.there, p)
    return Budgeted(error, tank), plus(v, change) if error.there else v


@feedback.position_up.member(Budgeted)
def _budgeted_up(s: Budgeted, u: Vector, f: Vector, xd: Vector, p: PositionParams) -> Budgeted:
    return Budgeted(error_taken(s.error, u, p.tick_s), tank_up(s.tank, u, f, xd, p.tick_s))


@feedback.position_send.member(Budgeted)
def _budgeted_send(
    s: Budgeted, wave: Vector, number: int, frame_s: float, p: PositionParams
) -> tuple[Budgeted, Vector]:
    tank, sent = tank_send(s.tank, wave, p)
    return Budgeted(error_sent(s.error, wave, sent, number, frame_s), tank), sent


@feedback.position_energies.member(Published)
def _published_energies(s: Published) -> Vector:
    return (s.spent_j,)


@feedback.position_energies.member(Budgeted)
def _budgeted_energies(s: Budgeted) -> Vector:
    tank = s.tank
    return tank.spent_j, tank_free_j(tank), tank.discarded_j, tank.deficit_j


@feedback.position_there.member(Published, Budgeted)
def seen_there(s: Any, there: bool) -> Any:
    """Note whether the server is there."""
    return s._replace(error=s.error._replace(there=there))


@feedback.position_up.member(Published)
def wave_taken(s: Any, u: Vector, f: Vector, xd: Vector, p: PositionParams) -> Any:
    """Note the wave that goes on; the node or nobody pays for it."""
    return s._replace(error=error_taken(s.error, u, p.tick_s))


@feedback.position_send.member(Published)
def wave_sent(
    s: Any, wave: Vector, number: int, frame_s: float, p: PositionParams
) -> tuple[Any, Vector]:
    """Note the wave that is sent, as it is."""
    return s._replace(error=error_sent(s.error, wave, wave, number, frame_s)), wave


@feedback.position_opened.member(Published, Budgeted)
def opened(s: Any) -> Any:
    """Return the feedback before the first packet, its list made here."""
    d = s.error.sending
    sending = d._replace(posted=[Posted(0, d.integral, 0.0)])
    return s._replace(error=s.error._replace(sending=sending))
