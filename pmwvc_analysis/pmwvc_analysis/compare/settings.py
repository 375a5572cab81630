# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of each controller in a comparison: baselines tuned by search, and the parameters
shown beside the numbers.

A baseline whose parameters nobody gave gets those that a search (:mod:`.search`) finds best for
this link, device, hand and contact: a comparison over the delay then compares controllers, not one
tuning with itself.
"""

import math
from collections.abc import Callable
from typing import Any

from pmwvc_analysis.compare.search import searched
from pmwvc_analysis.prediction.text import rule_loop, unknown_delay
from pmwvc_core.controllers.library import record_of
from pmwvc_core.params import BaselineParams
from pmwvc_core.scenario.scenario import Scenario

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
        found = record_of(scenario.controller).check(user.baseline, rule_loop(user, scenario))
        for name, margin in found.criteria.items() if found else ():
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
    wanted = list(ALWAYS)
    wanted += [f"server.{name}" for name in scenario.coupling.parameters]
    for name, more in SWITCHES:
        if _values(flat, name) != {"none"}:
            wanted += [name, *more]
    ends = {name for one in wanted for name in flat if name == one or name.endswith(f".{one}")}
    matrices = [user.name for user in scenario.users if user.master.impedance_matrix]
    ends -= {f"{name}.{IMPEDANCE}" for name in matrices}  # a matrix is in place of the number
    if len(matrices) == len(scenario.users):
        ends -= {IMPEDANCE}
    ends |= {name for name in flat if name.endswith(f"{IMPEDANCE}_matrix") and flat[name]}
    return {name: flat[name] for name in flat if name in ends}


def _values(flat: dict[str, Any], name: str) -> set[Any]:
    return {value for key, value in flat.items() if key == name or key.endswith(f".{name}")}
