# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The clocks of the playouts over constant delays, once they have settled.

They do not depend on signals (:mod:`pmwvc_core.law.channel.pace`). Where frames and steps are not
equally long, segments come early and late in turn; the lag that follows them comes to one course
around the hyperperiod, whatever the beginning was, and the model holds for that.

Equations: docs/theory.md 15.3.
"""

import functools
import math
from typing import Any

from pmwvc_analysis.models.ends import Ends
from pmwvc_analysis.models.links import Line
from pmwvc_core.law.channel.pace import RESTING_PACE, Pace, pace_arrive, pace_step
from pmwvc_core.law.channel.playout import Playout, add
from pmwvc_core.law.vectors import zero
from pmwvc_core.scenario.scenario import Scenario

SETTLED_S = 30.0  # many times as long as the lag takes to follow
STORE_S = 0.1  # more than a settled playout has in store


def rest_of(scenario: Scenario, lines: list[Line], ticks: int) -> tuple[int, int]:
    """Return the tick with which a loop begins, whole hyperperiods of so many ticks before tick 0,
    and that before which the clocks of its playouts are set: every link has answered by tick 0,
    and what playouts had in store before is played.
    """
    apart = 4 * max(max(line.frame.period, line.serve.period) for line in lines)
    answered, played = max(line.delay for line in lines) + apart, 0
    if scenario.strict:
        played = apart + math.ceil(STORE_S / scenario.tick_s)
    settled = -ticks * -(-played // ticks)
    return settled - ticks * (-(-answered // ticks) + 2 * scenario.strict), settled


def with_settled_paces(s: Ends, lines: list[Line], paces: list[tuple[Pace, Pace]]) -> Ends:
    """Return both ends with playouts whose clocks have settled."""
    loops, guests = list(s.loops), list(s.server.guests)
    for i, (line, (up, down)) in enumerate(zip(lines, paces, strict=True)):
        loops[i] = _with_pace(loops[i], down)
        for port in line.ports:
            guests[port] = _with_pace(guests[port], up)
    return s._replace(loops=tuple(loops), server=s.server._replace(guests=tuple(guests)))


def _with_pace(s: Any, pace: Pace) -> Any:
    playout = s.arrivals.playout
    stored = add(playout, zero(playout.undelivered), 0.0, STORE_S)
    return s._replace(arrivals=s.arrivals._replace(playout=Playout(pace, *stored[1:])))


def settled_paces(line: Line) -> tuple[Pace, Pace]:
    """Return the clocks of a user's playouts where a hyperperiod begins: at the server, and at the
    device.
    """
    frame, step, serve = line.frame.period, line.serve.period, line.serve.phase
    up, down = line.delay - line.delay_down, line.delay_down
    return (
        _settled(frame, step, up % frame, serve, line.tick_s),
        _settled(step, 1, (serve + down) % step, 0, line.tick_s),
    )


@functools.lru_cache(maxsize=4096)
def _settled(frame: int, step: int, arrival: int, phase: int, tick_s: float) -> Pace:
    """Return the same by ticks: length of frame and step, phase of arrivals and of
    steps.
    """
    ticks = math.lcm(frame, step)
    until = ticks * math.ceil(SETTLED_S / (ticks * tick_s))
    pace = RESTING_PACE
    for look in range(phase, until, step):
        while arrival <= look:
            pace = pace_arrive(pace, frame * tick_s)
            arrival += frame
        if arrival >= frame:
            pace, _, _ = pace_step(pace, step * tick_s)
    return pace
