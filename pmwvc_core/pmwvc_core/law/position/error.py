# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The position error between device and avatar, and the part of it that waves in flight explain;
it asks for a change of the returning wave, - K_p e (App. E, Eq. 3).

At either port xd = (u + v)/sqrt(2b), so with U, V the integrals of the waves

    sqrt(2b) (x_m - x_s - x_ref) = (U_m - U_s) - (V_s - V_m),

the waves on the uplink less those on the downlink: in the filter (group delay tau), sent after the
packet that the server answered (its echo), and still to be played::

    lag = [tau - (M-1)/2 T_c] y + integral of u since + (U_tx - U_tx(echo)) - down
    down = w T + (M-1)/2 T_c v (first-order hold), or what the playout holds

``x_ref`` makes the residual zero at an avatar's first packet. Both ends need equal impedances. K_p
is given, or follows the round trip tau: K_p = c sqrt(2b)/tau.
Equations: docs/theory.md 9.1, 9.2, 9.3, 9.8.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.vectors import Vector, minus, plus, scaled, zero
from pmwvc_core.law.wave.wave import free_velocity, wave_u

KEPT = 1024  # packets sent whose integral is kept
SMOOTHED_S = 0.5  # time constant of the round trip as packets show it
ADAPTED = 0.5  # c = K_p tau/sqrt(2b) of an adapted gain


class Posted(NamedTuple):
    """A packet sent: its number, integral of the waves and time of all up to it."""

    number: int
    integral: Vector  # [sqrt(W) s]
    time_s: float


class PositionError(NamedTuple):
    """What is known of the error. The list is never changed in place."""

    posted: list[Posted]  # at first only what comes before the first packet
    sent: Vector  # integral of the packets so far [sqrt(W) s]
    since: Vector  # integral of the waves after the last one
    y: Vector  # of the filter when that was sent [sqrt(W)]
    x: Vector  # [m] of the avatar, by the newest packet
    wave: Vector  # w T [sqrt(W) s]
    answered: Vector  # U_tx(echo), where it is remembered
    v: Vector  # of the tick before
    reference: Vector  # [m]
    residual: Vector  # [m]
    sent_s: float = 0.0  # for which the packets stand
    frame_s: float = 0.0  # the last one
    epoch: int = -1  # of the newest packet; -1: none yet
    number: int = 0
    anew: bool = False
    fresh: bool = False  # it remembers its echo, and no tick was since
    referenced: bool = False
    left: int = 0  # ticks for which the residual is known
    round_trip_s: float = 0.0  # lag of slow motion once around; 0: not known yet
    there: bool = False  # the server is not silent


class FeedbackParams(NamedTuple):
    """Position feedback: impedance, lags of filter and hold, and what it acts on and may spend."""

    impedance: Any
    tick_s: float
    frame_s: float
    filter_s: float  # tau - (M-1)/2 T_c; 0 on the strict channel
    hold_s: float  # (M-1)/2 T_c of the first-order hold
    of_residual: bool
    residual_ticks: int
    gain: float  # [sqrt(W)/m]
    adapts: bool
    lent_j: float
    most_j: float
    pays: bool  # for what it does; not as published


def error_sent(
    s: PositionError, y: Vector, wave: Vector, number: int, frame_s: float
) -> PositionError:
    """Note the filter's output, and what of it a packet carries [sqrt(W)]."""
    sent, sent_s = plus(s.sent, scaled(wave, frame_s)), s.sent_s + frame_s
    kept = s.posted[1:] if len(s.posted) > KEPT else s.posted
    posted = [*kept, Posted(number, sent, sent_s)]
    return s._replace(sent=sent, sent_s=sent_s, frame_s=frame_s, since=zero(y), y=y, posted=posted)


def error_taken(s: PositionError, u: Vector, h: float) -> PositionError:
    """Note the wave of a tick that goes on to the server [sqrt(W)]."""
    return s._replace(since=plus(s.since, scaled(u, h)))


def is_same_avatar(s: PositionError, packet: Packet) -> bool:
    """Tell whether a packet is of the avatar seen last."""
    return packet.epoch == s.epoch and packet.anew == s.anew


def is_news(s: PositionError, packet: Packet) -> bool:
    """Tell whether a packet is another one than the newest."""
    return packet.epoch != s.epoch or packet.number != s.number


def error_packet(
    s: PositionError, packet: Packet, there: bool, p: FeedbackParams
) -> PositionError:
    """Note the newest packet, where it is news, and whether the server is there."""
    if not is_news(s, packet):
        return s._replace(there=there)
    posted, place, answered, round_trip_s = s.posted, -1, s.answered, s.round_trip_s
    for i in range(len(posted)):
        if posted[i].number == packet.echo and packet.echo > 0:
            place = i
    if place >= 0:
        answered = posted[place].integral
        waiting_s = p.filter_s + 0.5 * s.frame_s + s.sent_s - posted[place].time_s
        now_s = waiting_s + packet.period_s + p.hold_s
        ratio = packet.period_s / SMOOTHED_S if round_trip_s > 0.0 else 1.0
        round_trip_s += min(ratio, 1.0) * (now_s - round_trip_s)
        posted = posted[place:]
    return s._replace(
        posted=posted, epoch=packet.epoch, number=packet.number, anew=packet.anew,
        x=packet.position, wave=scaled(packet.wave, packet.period_s), answered=answered,
        fresh=place >= 0, referenced=s.referenced and is_same_avatar(s, packet),
        round_trip_s=round_trip_s, there=there,
    )  # fmt: skip


def error_tick(
    s: PositionError, x: Vector, avatar_x: Vector, v: Vector, down: Vector, p: FeedbackParams
) -> tuple[PositionError, Vector]:
    """Return e [m] of a tick for a device at x: zero until an avatar's first packet. ``down``:
    integral of the waves on their way back [sqrt(W) s]; v: of the tick.
    """
    rest = reference = s.reference
    referenced, residual, left, error = s.referenced, s.residual, s.left, zero(x)
    if s.fresh:
        up = plus(scaled(s.y, p.filter_s), s.since)
        up = plus(up, minus(s.sent, s.answered))
        lag = scaled(free_velocity(p.impedance, minus(up, down)), 0.5)
        rest = minus(minus(x, s.x), lag)
        if not referenced:
            reference, referenced = rest, True
    if referenced and p.of_residual:
        if s.fresh:
            residual, left = minus(rest, reference), p.residual_ticks
        left -= 1
        error = residual if left >= 0 else error
    elif referenced:
        error = minus(minus(x, avatar_x), reference)
    s = s._replace(fresh=False, v=v, reference=reference, referenced=referenced,
                   residual=residual, left=left)  # fmt: skip
    return s, error


def asked(s: PositionError, error: Vector, p: FeedbackParams) -> Vector:
    """Return - K_p e [sqrt(W)]."""
    if p.adapts and s.round_trip_s > 0.0:
        return scaled(wave_u(p.impedance, error, zero(error)), -ADAPTED / s.round_trip_s)
    return scaled(error, -p.gain)
