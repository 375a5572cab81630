# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The cost of a session, what the search minimizes, and the settings that it tries.

RMS distance of device and avatar per 1 mm, RMS force error per 0.2 N and RMS distance of a carried
object from its target per 5 mm, added; 10 more where the session is restless (it keeps
oscillating, or that cannot be told), 100 where it failed: it diverged or a safety layer took over
(:mod:`pmwvc_analysis.verdicts.stability`), the users were never coupled, or the object was on the
mean further from its target than half the distance it should travel.
"""

import math
import zlib
from collections.abc import Mapping

import numpy as np

from pmwvc_analysis.traces.sums import rms
from pmwvc_core.frame import Presence
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

Range = tuple[float, float]
JND_M, JND_N, PATH_M = 1e-3, 0.2, 5e-3  # what is just noticed, and a tenth of the usual way
FAILED_COST, RESTLESS_COST = 100.0, 10.0
RESTLESS = "sustained oscillation"


def cost(*errors: float | None, restless: bool) -> float:
    """Return the cost of offset [m], force error [N] and path error [m]; None: not known."""
    total = RESTLESS_COST * restless
    for error, unit in zip(errors, (JND_M, JND_N, PATH_M), strict=True):
        total += math.inf if error is None else error / unit
    return min(total, FAILED_COST)


def failure(instability: str | None, path_m: float | None, scenario: Scenario) -> str:
    """Return in words how a session failed; empty where it did not."""
    if instability not in (None, RESTLESS):
        return instability
    if path_m is None:
        return "never coupled"
    return "" if path_m <= 0.5 * _way_m(scenario) else "task not done"


def path_error_m(traces: SessionTraces, scenario: Scenario) -> float | None:
    """Return the RMS distance of the object from its target since that began to move [m], 0 where
    nothing is carried; None where the users were not all coupled before.
    """
    server = traces.server
    if server is None:
        return None
    coupled = [state == Presence.COUPLED for state in server.state]
    together = np.flatnonzero(np.all(coupled, axis=0))
    if not len(together):
        return None
    if not _way_m(scenario):
        return 0.0
    moving = server.time_s >= server.time_s[together[0]] + scenario.task.move_s
    apart = (server.x_o - server.target)[moving]
    return rms(apart) if len(apart) else None


def _way_m(scenario: Scenario) -> float:
    """Return how far an object is carried [m]."""
    carried = scenario.task.moves and scenario.environment.movable
    task = scenario.task
    return math.hypot(task.distance_m, task.sideways_m, task.upwards_m) if carried else 0.0


def drawn(name: str, ranges: Mapping[str, Range], count: int, seed: int) -> list[dict[str, float]]:
    """Return values to try for a method: none (its defaults), then random ones of three digits."""
    rng = np.random.default_rng((seed, zlib.crc32(name.encode())))
    low, high = np.array(list(ranges.values())).reshape(-1, 2).T
    values = low * (high / low) ** rng.random((count - 1, len(ranges)))
    rounded = ([float(f"{value:.3g}") for value in row] for row in values.tolist())
    return [{}, *(dict(zip(ranges, row, strict=True)) for row in rounded)]
