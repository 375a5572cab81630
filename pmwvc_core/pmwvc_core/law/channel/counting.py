# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a receiver of the strict channel believes of a packet.

Packets carry running sums, so the difference of two is a segment for the playout, whatever was
lost, repeated or reordered in between. Its length is counted in packets; the sender's clock counts
only where packets stood for different times::

    U <- U + dU     dU = packet's U - U,   |dU| <= longest legal wave * time
    J <- J + dJ     dJ = packet's J - J,   0 <= dJ <= what that wave carries

The first packet of a sender, or after the avatar was placed anew, counts with its own wave alone.

Equations: docs/theory.md 17.24.
"""

from typing import NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.vectors import Vector, minus, plus, scaled, shortened
from pmwvc_core.law.wave.wave import wave_j

LONGEST_PERIOD_S = 10.0


class Counting(NamedTuple):
    """What was believed up to the newest packet."""

    integral: Vector  # [sqrt(W) s]
    energy_j: float
    sent_ns: int  # the sender's clock
    anew: bool
    least_s: float  # shortest and longest time for which packets stood
    most_s: float
    begun: bool


class Counted(NamedTuple):
    """A segment: whether the wave begins with it, its integral, energy and length."""

    begins: bool
    integral: Vector
    energy_j: float
    lasted_s: float


def resting_counting(nothing: Vector, period_s: float) -> Counting:
    """Return what is believed before the first packet."""
    return Counting(nothing, 0.0, 0, False, period_s, period_s, False)


def count(
    s: Counting, packet: Packet, passed_s: float, longest: float
) -> tuple[Counting, Counted]:
    """Return the segment that an accepted packet adds.

    ``passed_s`` is the time since the packet before, by this end's clock; ``longest`` the longest
    legal wave [sqrt(W)].
    """
    period_s = packet.period_s
    own = Counted(True, scaled(packet.wave, period_s), 0.0, period_s)
    noted = Counting(packet.integral, packet.energy_j, packet.sent_ns, packet.anew, period_s,
                     period_s, True)  # fmt: skip
    if packet.fresh or not s.begun:  # what it sent before it was followed does not count
        return noted, own
    least_s, most_s = min(s.least_s, period_s), max(s.most_s, period_s)
    lasted_s = period_s
    if packet.lost > 0:
        others_s = (packet.sent_ns - s.sent_ns) * 1e-9 - period_s
        lasted_s += min(max(others_s, packet.lost * least_s), packet.lost * most_s)
    lasted_s = min(lasted_s, passed_s + LONGEST_PERIOD_S)
    moved = shortened(minus(packet.integral, s.integral), longest * lasted_s)
    paid_j = min(max(packet.energy_j - s.energy_j, 0.0), 0.5 * longest**2 * lasted_s)
    integral, energy_j = plus(s.integral, moved), s.energy_j + paid_j
    noted = noted._replace(integral=integral, energy_j=energy_j)
    if packet.anew != s.anew:
        return noted, own._replace(energy_j=min(wave_j(packet.wave, period_s), paid_j))
    segment = Counted(False, moved, paid_j, lasted_s)
    return noted._replace(least_s=least_s, most_s=most_s), segment
