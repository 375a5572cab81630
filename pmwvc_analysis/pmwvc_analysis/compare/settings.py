# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of each controller in a comparison: baselines tuned by search, and the parameters
shown beside the numbers.

A baseline whose parameters nobody gave gets those that a random search finds best for this link,
device, hand and contact: the defaults and values drawn at random over ranges, evenly in their
logarithms, on the first 20 s of the scenario itself, all users alike. So a rival is judged on what
it was tuned for. Sessions of 10 s would choose values that oscillate later (tdpa at 50 ms).

The search minimizes a cost: RMS distance of device and avatar per 1 mm, RMS force error per 0.2 N
and RMS distance of a carried object from its target per 5 mm, added; 10 more where the session is
restless (it keeps oscillating, or that cannot be told), 100 where it failed: it diverged or a
safety layer took over (:mod:`pmwvc_analysis.verdicts.stability`), the users were never coupled, or
the object was on the mean further from its target than half the distance it should travel.
"""

import math
import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pmwvc_analysis.compare.measures import coherency_m, force_error_n
from pmwvc_analysis.prediction.text import rule_margins, unknown_delay
from pmwvc_analysis.traces.sums import rms
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.controllers.library import record_of
from pmwvc_core.controllers.record import Rule
from pmwvc_core.frame import Presence
from pmwvc_core.params import BaselineParams
from pmwvc_core.scenario.names import spec_of, split_user
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate
from pmwvc_core.traces import SessionTraces

Range = tuple[float, float]
COUNT, LONGEST_S, SEED = 120, 20.0, 1
JND_M, JND_N, PATH_M = 1e-3, 0.2, 5e-3  # what is just noticed, and a tenth of the usual way
FAILED_COST, RESTLESS_COST = 100.0, 10.0
RESTLESS = "sustained oscillation"
WORDS = (
    "RMS offset per 1 mm + RMS force error per 0.2 N + RMS distance of a carried object from its "
    "target per 5 mm, 10 more where it keeps oscillating, 100 where it fails"
)
GIVEN = "as given"
IMPEDANCE = "master.impedance"
ALWAYS = (IMPEDANCE, "master.filter.kind", "master.hold", "server.coupling")


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


def searched(
    scenario: Scenario, rule: Rule, progress: Callable[[float], None]
) -> tuple[Scenario, str]:
    """Return a scenario with the best parameters found for its baseline, and how, in words."""
    values = drawn(scenario.controller, rule.ranges, COUNT, SEED)
    tried = [_with(scenario, scenario.controller, each) for each in values]
    duration_s = min(scenario.duration_s, LONGEST_S)
    short = [replace(one, duration_s=duration_s) for one in tried]
    costs = np.array(simulate(short, keep=cost_of, progress=progress))
    best = int(np.argmin(costs))
    ranges = ", ".join(f"{leaf} {low:g} to {high:g}" for leaf, (low, high) in rule.ranges.items())
    words = f"the least cost, {costs[best]:.4g}, of {COUNT} settings"
    words += f" ({costs[0]:.4g} with the defaults)"
    if costs[best] == FAILED_COST:
        words = f"all {COUNT} settings fail, so the defaults are kept"
    words = f"by search over the first {duration_s:g} s: {words}; {ranges}; cost: {WORDS}"
    return tried[best], words


def _with(scenario: Scenario, group: str, values: Mapping[str, float]) -> Scenario:
    """Return a scenario with the defaults of a group of baseline parameters and these values."""
    own: dict[str, Any] = {group: replace(getattr(BaselineParams(), group), **values)}
    users = (replace(user, baseline=replace(user.baseline, **own)) for user in scenario.users)
    return replace(scenario, users=tuple(users))


def tuned(
    scenario: Scenario, progress: Callable[[float], None], *, given: bool = False
) -> tuple[Scenario, str | None]:
    """Return the scenario with its baseline tuned, and where its parameters are from, in words.

    A controller without parameters to search comes back as it is (None), as one whose parameters
    were ``given`` or are not the defaults.
    """
    rule = record_of(scenario.controller).rule
    if rule is None:
        return scenario, None
    of = scenario.controller
    default = getattr(BaselineParams(), of)
    words = GIVEN
    if not given and all(getattr(user.baseline, of) == default for user in scenario.users):
        scenario, words = searched(scenario, rule, progress)
    return scenario, words + _missed(scenario)


def _missed(scenario: Scenario) -> str:
    """Return in words the rules that a baseline's parameters miss, the worst user of each."""
    missed: dict[str, float] = {}
    unknown: dict[str, str] = {}
    for user in scenario.users:
        for name, margin in rule_margins(user, scenario).items():
            if math.isnan(margin):
                unknown[name] = f"; rule {name} unknown, as {unknown_delay(user)}"
            elif margin < 0.0:
                missed[name] = min(margin, missed.get(name, 0.0))
    short = ", ".join(f"{name} by {-margin:.3g} N s/m" for name, margin in missed.items())
    return "".join([f"; misses rule {short}" if short else "", *unknown.values()])


def parameters_of(scenario: Scenario) -> dict[str, Any]:
    """Return a controller's own parameters by dotted name, per user where users differ: with waves
    those that are always told, and of the masters what is not the default.
    """
    flat, record = scenario.flat(), record_of(scenario.controller)
    if not record.waves:
        return {name: flat[name] for name in flat if f".{record.name}." in f".{name}"}
    always = {*ALWAYS, *(f"server.{name}" for name in scenario.coupling.parameters)}
    found = {}
    for name, value in flat.items():
        path = split_user(name)[1]
        own = path.startswith("master.") and value != spec_of(path).default
        if (own or path in always) and not flat.get(f"{name}_matrix"):  # in place of the number
            found[name] = value
    return found
