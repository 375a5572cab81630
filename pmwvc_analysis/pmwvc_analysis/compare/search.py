# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The random search for the parameters of a controller, of ``pmwvc compare`` and the benchmark.

Tried are the defaults and values drawn at random over ranges, evenly in their logarithms. The
settings with the least cost (:mod:`.criterion`) are kept.

A comparison searches for each of its scenarios: 120 settings on the link, hands and packet fates
of the scenario itself, its first 20 s, all users alike. So a rival is judged on what it was tuned
for. Sessions of 10 s would choose values that oscillate later (tdpa at 50 ms).
"""

import dataclasses
import zlib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from pmwvc_analysis.compare.criterion import FAILED_COST, WORDS, cost_of
from pmwvc_core.controllers.record import Rule
from pmwvc_core.numeric import Array
from pmwvc_core.params import BaselineParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate

Range = tuple[float, float]
COUNT, LONGEST_S, SEED = 120, 20.0, 1


def drawn(name: str, ranges: Mapping[str, Range], count: int, seed: int) -> list[dict[str, float]]:
    """Return values to try for a method: none (its defaults), then random ones of three digits."""
    rng = np.random.default_rng((seed, zlib.crc32(name.encode())))

    def at(row: Array) -> dict[str, float]:
        shares = zip(ranges.items(), row, strict=True)
        return {
            leaf: float(f"{low * (high / low) ** share:.3g}")
            for (leaf, (low, high)), share in shares
        }

    return [{}, *(at(row) for row in rng.random((count - 1, len(ranges))))]


def searched(
    scenario: Scenario, rule: Rule, progress: Callable[[float], None]
) -> tuple[Scenario, str]:
    """Return a scenario with the best parameters found for its baseline, and how, in words."""
    values = drawn(scenario.controller, rule.ranges, COUNT, SEED)
    tried = [_with(scenario, rule.group, each) for each in values]
    duration_s = min(scenario.duration_s, LONGEST_S)
    short = [dataclasses.replace(one, duration_s=duration_s) for one in tried]
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
    params = dataclasses.replace(getattr(BaselineParams(), group), **values)
    own: dict[str, Any] = {group: params}
    users = (
        dataclasses.replace(user, baseline=dataclasses.replace(user.baseline, **own))
        for user in scenario.users
    )
    return dataclasses.replace(scenario, users=tuple(users))
