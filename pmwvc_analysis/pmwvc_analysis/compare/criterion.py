# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The cost of a session, which the search for a controller's parameters minimizes.

RMS distance of device and avatar per 1 mm, RMS force error per 0.2 N and RMS distance of a
carried object from its target per 5 mm, added; 10 more where the session is restless (it keeps
oscillating, or that cannot be told), 100 where it failed: it diverged or a safety layer took over
(:mod:`pmwvc_analysis.verdicts.stability`), the users were never coupled, or the object was on the
mean further from its target than half the distance it should travel.
"""

import math

import numpy as np

from pmwvc_analysis.compare.measures import coherency_m, force_error_n
from pmwvc_analysis.traces.sums import rms
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.frame.rows import Presence
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

JND_M, JND_N, PATH_M = 1e-3, 0.2, 5e-3  # what is just noticed, and a tenth of the usual way
FAILED_COST, RESTLESS_COST = 100.0, 10.0
RESTLESS = "sustained oscillation"
WORDS = (
    "RMS offset per 1 mm + RMS force error per 0.2 N + RMS distance of a carried object from its "
    "target per 5 mm, 10 more where it keeps oscillating, 100 where it fails"
)


def cost_of(traces: SessionTraces, scenario: Scenario) -> float:
    """Return the cost of a session."""
    judged, path_m = verdict(traces, scenario), path_error_m(traces, scenario)
    if failure(judged.instability, path_m, scenario):
        return FAILED_COST
    return cost(coherency_m(traces), force_error_n(traces), path_m, restless=not judged.stable)


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
    together = np.flatnonzero(
        np.all([state == Presence.COUPLED for state in server.state], axis=0)
    )
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
    return math.hypot(scenario.task.distance_m, scenario.task.sideways_m) if carried else 0.0
