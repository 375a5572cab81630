# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The lag of the strict channel once around.

A playout follows how late packets come: where delays are constant it is as late as the greatest
age a of the newest packet at a step of the server, and the delay d down. The server takes a step's
wave as a whole and answers with it, so that on average half a step passes at its side each way:

    tau = a + d + T_VE

without anti-aliasing filter, rate drop or hold: the channel counts the motion of every tick whole,
and plays its wave tick by tick. Where they are not constant it settles at the lateness L with
r E[(late - L)+] = E[(L - late)+], r = EARLY_S/LATE_S (:mod:`pmwvc_core.wave.pace`): from the mean
(sqrt(r) - 1)/(sqrt(r) + 1) of the way to the longest delay under uniform jitter, and later by what
packets lost one by one make of the next ones. A deadband adds the time for which a frame waits at
most. Delays of other shape and bursts are not counted.

Equations: docs/theory.md 17.7.
"""

import math

import numpy as np
from scipy.optimize import brentq

from pmwvc_analysis.models.links import delay_ticks, hyperperiod_ticks, times_of
from pmwvc_core.law.channel.pace import EARLY_S, LATE_S
from pmwvc_core.network.effects import active, longest_s, mean_s
from pmwvc_core.params import DeadbandParams, LinkParams
from pmwvc_core.scenario.scenario import Scenario, User

SHARE = (math.sqrt(EARLY_S / LATE_S) - 1.0) / (math.sqrt(EARLY_S / LATE_S) + 1.0)
RARE = 1e-6  # longer runs of lost packets do not count


def strict_lag_s(user: User, scenario: Scenario, *, live: bool) -> float:
    """Return tau on the strict channel [s]."""
    tick_s, period_s, frame_s = scenario.tick_s, scenario.server.period_s, user.master.frame_s
    up = _oldest_s(user, scenario, live=live) + _lost_s(user.link_up, frame_s)
    down = _latest_s(user.link_down, tick_s, live=live)
    down += _lost_s(user.link_down, period_s)
    up += _held_back_s(user.master.deadband, frame_s)
    down += _held_back_s(user.contact.deadband, period_s)
    return up + down + period_s + user.master.bank.lag_s


def _held_back_s(deadband: DeadbandParams, interval_s: float) -> float:
    """Return how long a deadband lets a frame wait for its packet at most [s]."""
    frames = math.floor(deadband.longest_s / interval_s + 1e-9) if deadband.is_on else 1
    return max(frames - 1, 0) * interval_s


def _oldest_s(user: User, scenario: Scenario, *, live: bool) -> float:
    """Return the greatest age of the newest packet at a step of the server [s]."""
    sent, _, served = times_of(user, scenario, live=live)
    tick_s = scenario.tick_s
    delay = round(_latest_s(user.link_up, tick_s, live=live) / tick_s)
    looks = range(served.phase, served.phase + hyperperiod_ticks(scenario), served.period)
    return max(look - sent.last(look - delay) for look in looks) * tick_s


def _latest_s(link: LinkParams, tick_s: float, *, live: bool) -> float:
    """Return the delay that a playout follows, in whole ticks [s]: exact where it is constant or
    uniform, the mean one where the longest is not known.
    """
    if not any(effect.spreads for effect in active(link)):
        return delay_ticks(link, tick_s=tick_s, live=live) * tick_s
    longest, mean = longest_s(link), mean_s(link)
    slower = SHARE * (longest - mean) if math.isfinite(longest) else 0.0
    return math.ceil((mean + slower) / tick_s - 1e-9) * tick_s


def _lost_s(link: LinkParams, interval_s: float) -> float:
    """Return what packets that are lost one by one add to the lag that a playout follows [s]."""
    loss = float(np.max(link.loss))
    if not 0.0 < loss < 1.0:
        return 0.0
    packets = np.arange(1, 1 + math.ceil(math.log(RARE) / math.log(loss)))
    weights = packets * loss ** (packets - 1)  # a segment counts by its length

    def early(lag: float) -> float:
        late = packets - 1 - lag
        return float(np.sum(weights * np.where(late > 0.0, -EARLY_S / LATE_S, -1.0) * late))

    return interval_s * float(brentq(early, 0.0, float(packets[-1])))
