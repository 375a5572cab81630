# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of each controller in a comparison: baselines tuned by search, and the parameters
shown beside the numbers.

A baseline whose parameters nobody gave gets those that a random search finds best for this link,
device, hand and contact: a comparison over the delay then compares controllers, not one tuning
with itself. Tried are the defaults and values drawn at random over ranges, evenly in their
logarithms. The settings with the least cost (:mod:`.criterion`) are kept.

A comparison searches for each of its scenarios: 120 settings on the link, hands and packet fates
of the scenario itself, its first 20 s, all users alike. So a rival is judged on what it was tuned
for. Sessions of 10 s would choose values that oscillate later (tdpa at 50 ms).
"""

import dataclasses
import math
import zlib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from pmwvc_analysis.compare.criterion import FAILED_COST, WORDS, cost_of
from pmwvc_analysis.prediction.text import rule_margins, unknown_delay
from pmwvc_core.controllers.library import record_of
from pmwvc_core.controllers.record import Rule
from pmwvc_core.params import BaselineParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate

Range = tuple[float, float]
COUNT, LONGEST_S, SEED = 120, 20.0, 1


def drawn(name: str, ranges: Mapping[str, Range], count: int, seed: int) -> list[dict[str, float]]:
    """Return values to try for a method: none (its defaults), then random ones of three digits."""
    rng = np.random.default_rng((seed, zlib.crc32(name.encode())))

    tried: list[dict[str, float]] = [{}]
    for row in rng.random((count - 1, len(ranges))).tolist():
        shares = zip(ranges.items(), row, strict=True)
        tried.append(
            {leaf: float(f"{low * (high / low) ** at:.3g}") for (leaf, (low, high)), at in shares}
        )
    return tried


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


GIVEN = "as given"
IMPEDANCE = "master.impedance"
ALWAYS = (IMPEDANCE, "master.filter.kind", "master.hold", "server.coupling")
SWITCHES = (  # shown with waves where they are on: name, what belongs to it
    ("master.velocity_filter.kind", ("master.velocity_filter.order",)),
    ("master.bank.kind", ("master.local_model.stiffness",)),
    ("master.position.feedback", ("master.position.gain",)),
)


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
    default = getattr(BaselineParams(), rule.group)
    words = GIVEN
    if not given and all(getattr(user.baseline, rule.group) == default for user in scenario.users):
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
    """Return a controller's own parameters by dotted name, per user where users differ."""
    flat, record = scenario.flat(), record_of(scenario.controller)
    if not record.waves:
        group = record.rule.group if record.rule else record.name
        names = [name for name in flat if f"baseline.{group}." in f".{name}"]
        return {name: flat[name] for name in names}
    wanted = [*ALWAYS, *(f"server.{name}" for name in scenario.coupling.parameters)]
    for name, more in SWITCHES:
        if {flat[key] for key in flat if key == name or key.endswith(f".{name}")} != {"none"}:
            wanted += [name, *more]
    ends = {name for one in wanted for name in flat if name == one or name.endswith(f".{one}")}
    matrices = [user.name for user in scenario.users if user.master.impedance_matrix]
    ends -= {f"{name}.{IMPEDANCE}" for name in matrices}  # a matrix is in place of the number
    if len(matrices) == len(scenario.users):
        ends -= {IMPEDANCE}
    ends |= {name for name in flat if name.endswith(f"{IMPEDANCE}_matrix") and flat[name]}
    return {name: flat[name] for name in flat if name in ends}
