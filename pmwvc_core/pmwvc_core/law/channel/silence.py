# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a receiver notes of the other end: its silence, and what is believed of its packets.

On the strict channel the time follows what packets do: three of their intervals (a longer one
counts at once), and beyond the lateness that they usually have, what the playout keeps at hand. A
packet also tells whether its sender has waves of this end at hand; both ends brake while either
has not.

Packets carry running sums, so on the strict channel the difference of two is a segment for the
playout, whatever was lost, repeated or reordered in between. Its length is counted in packets; the
sender's clock counts only where packets stood for different times::

    U <- U + dU     dU = packet's U - U,   |dU| <= longest legal wave * time
    J <- J + dJ     dJ = packet's J - J,   0 <= dJ <= what that wave carries

The first packet of a sender, or after the avatar was placed anew, counts with its own wave alone.

Times of this end's clock are whole nanoseconds. Equations: docs/theory.md 17.24.
"""

import math
from typing import NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.vectors import Vector, minus, plus, scaled, shortened
from pmwvc_core.law.wave.wave import wave_j

LATENESSES = 4.0  # usual ones, until silence begins
SMOOTHED = 1.0 / 16.0  # weight of a packet in interval and lateness
NEVER_NS = -1
LONGEST_PERIOD_S = 10.0


class Silence(NamedTuple):
    """When packets came, and how they usually do."""

    accepted_ns: int  # the newest; NEVER_NS before the first
    limit_ns: int  # from then on the other end is silent
    interval_s: float  # for which packets stand
    lateness_s: float  # mean deviation of their arrivals from it
    unreceived_ns: int  # since when the other end waits; NEVER_NS where it does not
    number: int  # of the newest packet; 0: none yet


def noted_packet(s: Silence, number: int, now_ns: int, waits: bool) -> Silence:
    """Note a packet by its number; ``waits``: its sender has no waves of this end."""
    unreceived_ns = s.unreceived_ns
    if not waits:
        unreceived_ns = NEVER_NS
    elif unreceived_ns == NEVER_NS:
        unreceived_ns = now_ns
    return s._replace(accepted_ns=now_ns, unreceived_ns=unreceived_ns, number=number)


def followed(
    s: Silence, passed_s: float, lasted_s: float, period_s: float, timeout_s: float
) -> Silence:
    """Take over how packets come: this one so long [s] after the one before, for so much time."""
    lateness_s = s.lateness_s + SMOOTHED * (abs(passed_s - lasted_s) - s.lateness_s)
    interval_s = max(s.interval_s + SMOOTHED * (period_s - s.interval_s), period_s)
    usual_s = 3.0 * interval_s + LATENESSES * lateness_s
    limit_ns = round(max(timeout_s, usual_s) * 1e9)
    return s._replace(limit_ns=limit_ns, interval_s=interval_s, lateness_s=lateness_s)


def is_silent(s: Silence, now_ns: int) -> bool:
    """Tell whether nothing came for too long (also before the first packet)."""
    return s.accepted_ns == NEVER_NS or now_ns - s.accepted_ns > s.limit_ns


def silence_s(s: Silence, now_ns: int) -> float:
    """Return the time since the newest packet [s]; infinite before the first."""
    return math.inf if s.accepted_ns == NEVER_NS else (now_ns - s.accepted_ns) * 1e-9


def is_unreceived(s: Silence, now_ns: int) -> bool:
    """Tell whether the other end has had nothing of this one for too long."""
    return s.unreceived_ns != NEVER_NS and now_ns - s.unreceived_ns > s.limit_ns


class Counting(NamedTuple):
    """What was believed of a sender up to its newest packet."""

    integral: Vector  # [sqrt(W) s]
    energy_j: float
    sent_ns: int  # the sender's clock
    anew: bool
    least_s: float  # shortest and longest time for which packets stood
    most_s: float
    begun: bool


def counted(
    s: Counting, packet: Packet, passed_s: float, longest: float
) -> tuple[Counting, bool, Vector, float, float]:
    """Return the segment that an accepted packet adds: whether it goes on with the one before, its
    integral, energy and length. ``passed_s`` is the time since the packet before, by this end's
    clock.
    """
    lasted_s = period_s = packet.period_s
    noted = Counting(packet.integral, packet.energy_j, packet.sent_ns, packet.anew, period_s,
                     period_s, True)  # fmt: skip
    own = scaled(packet.wave, period_s)
    if packet.fresh or not s.begun:  # what it sent before it was followed does not count
        return noted, False, own, 0.0, period_s
    least_s, most_s = min(s.least_s, period_s), max(s.most_s, period_s)
    if packet.lost > 0:
        others_s = (packet.sent_ns - s.sent_ns) * 1e-9 - period_s
        lasted_s += min(max(others_s, packet.lost * least_s), packet.lost * most_s)
    lasted_s = min(lasted_s, passed_s + LONGEST_PERIOD_S)
    moved = shortened(minus(packet.integral, s.integral), longest * lasted_s)
    paid_j = min(max(packet.energy_j - s.energy_j, 0.0), 0.5 * longest**2 * lasted_s)
    noted = noted._replace(integral=plus(s.integral, moved), energy_j=s.energy_j + paid_j)
    if packet.anew != s.anew:
        return noted, False, own, min(wave_j(packet.wave, period_s), paid_j), period_s
    return noted._replace(least_s=least_s, most_s=most_s), True, moved, paid_j, lasted_s
