# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The clocks of the playouts over constant delays, once they have settled.

They do not depend on signals (:mod:`pmwvc_core.wave.pace`). Where frames and steps are not equally
long, segments come early and late in turn; the lag that follows them comes to one course around
the hyperperiod, whatever the beginning was, and the model holds for that.

Equations: docs/theory.md 15.3.
"""

import functools
import math

from pmwvc_analysis.models.links import delay_ticks, serve_phase
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.state import State
from pmwvc_core.wave.pace import Pace

SETTLED_S = 30.0  # many times as long as the lag takes to follow


def settled_paces(user: User, scenario: Scenario, *, live: bool) -> dict[str, State]:
    """Return the clocks of a user's playouts where a hyperperiod begins: ``up`` at the server,
    ``down`` at the device.
    """
    tick_s, frame, step = scenario.tick_s, user.master.rate_drop, scenario.period_ticks
    serve = serve_phase(scenario, live=live)
    up = delay_ticks(user.link_up, tick_s=tick_s, live=live)
    down = delay_ticks(user.link_down, tick_s=tick_s, live=live)
    return {
        "up": _settled(frame, step, up % frame, serve, tick_s),
        "down": _settled(step, 1, (serve + down) % step, 0, tick_s),
    }


@functools.lru_cache(maxsize=4096)
def _settled(frame: int, step: int, arrival: int, phase: int, tick_s: float) -> State:
    """Return the same by ticks: length of frame and step, phase of arrivals and of
    steps.
    """
    ticks = math.lcm(frame, step)
    until = ticks * math.ceil(SETTLED_S / (ticks * tick_s))
    pace = Pace()
    for look in range(phase, until + step, step):
        while arrival <= min(look, until - 1):
            pace.arrive(frame * tick_s)
            arrival += frame
        if look < until and arrival >= frame:
            pace.step(step * tick_s)
    return pace.snapshot()
