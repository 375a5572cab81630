# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What one end says to the other: packets with running sums, a deadband that leaves some out; and
what a receiver notes and believes of them. A packet is what the laws see of a message.

::

    integral <- integral + w T          energy <- energy + |w|^2 T/2
    held back where  |w - w_sent| <= ratio |w_sent|

(Hinterseer et al., 2008) unless the next packet, with the mean of both, would stand for too long.
The other end is silent after three intervals of its packets (a longer one counts at once) and, on
the strict channel, the lateness that they usually have. The difference of two packets' sums is a
segment, whatever was lost in between. Its length is counted in packets; the sender's clock counts
only where packets stood for different times::

    U <- U + dU     dU = packet's U - U,   |dU| <= longest legal wave * time
    J <- J + dJ     dJ = packet's J - J,   0 <= dJ <= what that wave carries

The first packet of a sender, or after the avatar was placed anew, counts with its own wave alone.
Times of this end's clock are whole nanoseconds. Equations: docs/theory.md 17.11, 17.24.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, minus, plus, scaled, shortened, squared
from pmwvc_core.law.wave.wave import wave_j

LAST_NUMBER = (1 << 32) - 1  # 1 follows


class Packet(NamedTuple):
    """One sample of a wave with the running sums of all samples before it."""

    number: int  # 1, 2, 3 ...
    sent_ns: int  # the sender's clock
    period_s: float  # time that the sample stands for
    wave: Vector  # [sqrt(W)]; without waves a velocity, a force or a position
    integral: Vector  # [sqrt(W) s] running sum of wave * period
    energy_j: float  # running sum: of |wave|^2 period/2, or what was paid for (strict channel)
    position: Vector  # [m] of the sending end
    short: bool  # the sender's playout lacks energy
    waits: bool  # the sender has nothing of the receiver's waves at hand
    anew: bool  # flips whenever the server places the user's avatar anew
    leaves: bool  # the last one of its sender
    level: int  # of the impedance behind the wave (:mod:`pmwvc_core.law.wave.following`)
    extra: Vector  # signals that a controller declares, beside the wave
    echo: int  # number of the newest packet that the sender had of the other end; 0: none
    # Found by the receiver:
    fresh: bool  # begins: the first one, or of a sender that started again
    lost: int  # numbers between it and the one accepted before
    epoch: int  # of the sender: another one where it started again


def no_packet(rest: Vector, extra: Vector) -> Packet:
    """Return what stands for a packet where there is none; ``rest`` are zeros."""
    return Packet(
        0, 0, 0.0, rest, rest, 0.0, rest, False, False, False, False, 0, extra, 0, False, 0, 0
    )


class Sent(NamedTuple):
    """What a port sends at a frame start."""

    wave: Vector
    position: Vector
    energy_j: float  # running sum where the port keeps it; below zero: that of the waves sent
    extra: Vector
    level: int  # of the impedance behind it


class Packing(NamedTuple):
    """The sums of a sender, and the last packet as far as the next one depends on it."""

    integral: Vector  # [sqrt(W) s]
    sent_integral: Vector  # up to the samples held back since the last packet
    wave: Vector  # of the last packet
    number: int = 0
    energy_j: float = 0.0
    held_s: float = 0.0  # time of the samples held back
    flags: int = 0  # of the last packet
    events: int = 0  # of the limits, as noted last


class Deadband(NamedTuple):
    """Ratio of two waves that is not felt (none: below zero), longest time [s]."""

    ratio: float
    longest_s: float


def pack(
    s: Packing, sent: Sent, period_s: float, now_ns: int, news: tuple[bool, bool], anew: bool,
    leaves: bool, echo: int, events: int, p: Deadband,
) -> tuple[Packing, Packet, bool]:  # fmt: skip
    """Add a sample; return its packet, and whether that is sent: anything new in it needs one."""
    short, waits = news
    integral = plus(s.integral, scaled(sent.wave, period_s))
    energy_j = s.energy_j + wave_j(sent.wave, period_s)
    flags = (events != s.events) * 8 + waits * 4 + anew * 2 + leaves
    number, held_s, wave = s.number % LAST_NUMBER + 1, s.held_s, sent.wave
    same = p.ratio >= 0.0 and s.number > 0 and flags == s.flags
    fits = held_s + 2.0 * period_s <= p.longest_s
    held_back = same and fits and squared(minus(wave, s.wave)) <= p.ratio**2 * squared(s.wave)
    if held_back:
        before = s.sent_integral if held_s > 0.0 else s.integral
        s = s._replace(
            integral=integral, energy_j=energy_j, held_s=held_s + period_s, sent_integral=before,
            events=events,
        )  # fmt: skip
    else:
        if held_s > 0.0:
            period_s += held_s
            wave = scaled(minus(integral, s.sent_integral), 1.0 / period_s)
        s = Packing(integral, integral, wave, number, energy_j, 0.0, flags, events)
    own = sent.energy_j if sent.energy_j >= 0.0 else energy_j
    packet = Packet(
        number, now_ns, period_s, wave, integral, own, sent.position, short, waits, anew, leaves,
        sent.level, sent.extra, echo, False, 0, 0,
    )  # fmt: skip
    return s, packet, not held_back


LATENESSES = 4.0  # usual ones, until silence begins
SMOOTHED = 1.0 / 16.0  # weight of a packet in interval and lateness
NEVER_NS = -1
LONGEST_PERIOD_S = 10.0


class Silence(NamedTuple):
    """When packets came, and how they usually do."""

    limit_ns: int  # from then on the other end is silent
    interval_s: float  # for which packets stand
    lateness_s: float = 0.0  # mean deviation of their arrivals from it
    accepted_ns: int = NEVER_NS  # the newest
    unreceived_ns: int = NEVER_NS  # since when the other end waits
    number: int = 0  # of the newest packet; 0: none yet


def noted_packet(s: Silence, number: int, now_ns: int, waits: bool) -> Silence:
    """Note a packet by its number; ``waits``: its sender has no waves of this end."""
    since_ns = now_ns if s.unreceived_ns == NEVER_NS else s.unreceived_ns
    since_ns = since_ns if waits else NEVER_NS
    return s._replace(accepted_ns=now_ns, unreceived_ns=since_ns, number=number)


def usual(s: Silence, period_s: float, late_s: float, timeout_s: float) -> Silence:
    """Note how late a packet was, or how early; at the earliest it is silent after a timeout."""
    lateness_s = s.lateness_s + SMOOTHED * (late_s - s.lateness_s)
    interval_s = max(s.interval_s + SMOOTHED * (period_s - s.interval_s), period_s)
    limit_ns = round(max(timeout_s, 3.0 * interval_s + LATENESSES * lateness_s) * 1e9)
    return s._replace(limit_ns=limit_ns, interval_s=interval_s, lateness_s=lateness_s)


def silence(s: Silence, now_ns: int) -> tuple[float, bool, bool]:
    """Return the time since the newest packet, infinite before the first [s]; whether that is too
    long; and whether the other end has had nothing of this one for too long.
    """
    passed_s, silent, waited_ns = math.inf, True, s.accepted_ns - s.unreceived_ns
    if s.accepted_ns != NEVER_NS:
        passed_s, silent = (now_ns - s.accepted_ns) * 1e-9, now_ns - s.accepted_ns > s.limit_ns
    return passed_s, silent, s.unreceived_ns != NEVER_NS and waited_ns > s.limit_ns


class Counting(NamedTuple):
    """What was believed of a sender up to its newest packet."""

    integral: Vector  # [sqrt(W) s]
    least_s: float  # shortest and longest time for which packets stood
    most_s: float
    energy_j: float = 0.0
    sent_ns: int = 0  # the sender's clock
    anew: bool = False
    begun: bool = False


def counted(
    s: Counting, packet: Packet, passed_s: float, longest: float
) -> tuple[Counting, bool, Vector, float, float]:
    """Return the segment that an accepted packet adds: whether it goes on with the one before, its
    integral, energy and length. ``passed_s``: since the packet before, by this end's clock.
    """
    lasted_s = period_s = packet.period_s
    own_j, sent_ns = packet.energy_j, packet.sent_ns
    noted = Counting(packet.integral, period_s, period_s, own_j, sent_ns, packet.anew, True)
    own = scaled(packet.wave, period_s)
    if packet.fresh or not s.begun:  # what it sent before it was followed does not count
        return noted, False, own, 0.0, period_s
    least_s, most_s = min(s.least_s, period_s), max(s.most_s, period_s)
    if packet.lost > 0:
        others_s = (sent_ns - s.sent_ns) * 1e-9 - period_s
        lasted_s += min(max(others_s, packet.lost * least_s), packet.lost * most_s)
    lasted_s = min(lasted_s, passed_s + LONGEST_PERIOD_S)
    moved = shortened(minus(packet.integral, s.integral), longest * lasted_s)
    paid_j = min(max(own_j - s.energy_j, 0.0), 0.5 * longest**2 * lasted_s)
    noted = noted._replace(integral=plus(s.integral, moved), energy_j=s.energy_j + paid_j)
    if packet.anew != s.anew:
        return noted, False, own, min(wave_j(packet.wave, period_s), paid_j), period_s
    return noted._replace(least_s=least_s, most_s=most_s), True, moved, paid_j, lasted_s
