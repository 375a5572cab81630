# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The silence of the other end: for how long nothing may come, and what this end does meanwhile.

On the strict channel the time follows what packets do: three of their intervals (a longer one
counts at once), and beyond the lateness that they usually have, what the playout keeps at hand. A
packet also tells whether its sender has waves of this end at hand; both ends brake while either
has not.

Times of this end's clock are whole nanoseconds.
"""

import math
from typing import NamedTuple

LATENESSES = 4.0  # usual ones, until silence begins
SMOOTHED = 1.0 / 16.0  # weight of a packet in interval and lateness
NEVER_NS = -1


class Silence(NamedTuple):
    """When packets came, and how they usually do."""

    accepted_ns: int  # the newest; NEVER_NS before the first
    limit_ns: int  # from then on the other end is silent
    interval_s: float  # for which packets stand
    lateness_s: float  # mean deviation of their arrivals from it
    unreceived_ns: int  # since when the other end waits; NEVER_NS where it does not
    number: int  # of the newest packet; 0: none yet


def resting_silence(timeout_s: float, period_s: float) -> Silence:
    """Return the silence before the first packet, with the least time until it counts [s]."""
    limit_ns = round(max(timeout_s, 3.0 * period_s) * 1e9)
    return Silence(NEVER_NS, limit_ns, period_s, 0.0, NEVER_NS, 0)


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
