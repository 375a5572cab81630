# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The lag of the strict channel once around.

A playout is as late as the latest packet that it met: up, the greatest age a of the newest packet
at a step of the server; down, the longest delay d. The server takes a step's wave as a whole and
answers with it, so that on average half a step passes at its side each way:

    tau = a + d + T_VE

without anti-aliasing filter, rate drop or hold: the channel counts the motion of every tick whole,
and plays its wave tick by tick. A packet
that is lost makes the next one a frame later; of N packets that get lost with the probability p
the longest run is log N / log(1/p) on average. A deadband adds the time for which a frame waits at
most. What comes on top (margins; delays beyond one
deviation; bursts) is not counted.

Equations: docs/theory.md 17.7.
"""

import math

import numpy as np

from pmwvc_analysis.models.links import Times, delay_ticks, hyperperiod_ticks, serve_phase
from pmwvc_core.network.effects import active, longest_s, mean_s
from pmwvc_core.params import DeadbandParams, LinkParams
from pmwvc_core.scenario.scenario import Scenario, User


def strict_lag_s(user: User, scenario: Scenario, *, live: bool) -> float:
    """Return tau on the strict channel [s]."""
    tick_s, period_s, frame_s = scenario.tick_s, scenario.server.period_s, user.master.frame_s
    up = _oldest_s(user, scenario, live=live) + _lost_s(user.link_up, frame_s, scenario)
    down = _latest_s(user.link_down, tick_s, live=live)
    down += _lost_s(user.link_down, period_s, scenario)
    up += _held_back_s(user.master.deadband, frame_s)
    down += _held_back_s(user.contact.deadband, period_s)
    return up + down + period_s + user.master.bank.lag_s


def _held_back_s(deadband: DeadbandParams, interval_s: float) -> float:
    """Return how long a deadband lets a frame wait for its packet at most [s]."""
    frames = math.floor(deadband.longest_s / interval_s + 1e-9) if deadband.is_on else 1
    return max(frames - 1, 0) * interval_s


def _oldest_s(user: User, scenario: Scenario, *, live: bool) -> float:
    """Return the greatest age of the newest packet at a step of the server [s]."""
    sent = Times(user.master.rate_drop, 0)
    served = Times(scenario.period_ticks, serve_phase(scenario, live=live))
    tick_s = scenario.tick_s
    delay = round(_latest_s(user.link_up, tick_s, live=live) / tick_s)
    looks = range(served.phase, served.phase + hyperperiod_ticks(scenario), served.period)
    return max(look - sent.last(look - delay) for look in looks) * tick_s


def _latest_s(link: LinkParams, tick_s: float, *, live: bool) -> float:
    """Return the longest delay, in whole ticks [s]; the mean one where it is not known."""
    if not any(effect.spreads for effect in active(link)):
        return delay_ticks(link, tick_s=tick_s, live=live) * tick_s
    longest = longest_s(link)
    known = longest if math.isfinite(longest) else mean_s(link)
    return math.ceil(known / tick_s - 1e-9) * tick_s


def _lost_s(link: LinkParams, interval_s: float, scenario: Scenario) -> float:
    """Return the longest run of lost packets to be expected in the session [s]."""
    loss = float(np.max(link.loss))
    if not 0.0 < loss < 1.0:
        return 0.0
    packets = max(scenario.duration_s / interval_s, 1.0)
    return interval_s * math.log(packets) / math.log(1.0 / loss)
