# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of each controller in a comparison: baselines tuned by their published rules, and
the parameters shown beside the numbers.

A baseline whose parameters nobody gave gets those of its rule (:mod:`pmwvc_core.baselines.tuning`)
for this link, device, hand and contact: a comparison over the delay then compares controllers, not
one tuning with itself.
"""

import dataclasses
import math
from typing import Any

from pmwvc_analysis.prediction.text import rule_loop, unknown_delay
from pmwvc_core.controllers.library import record_of
from pmwvc_core.controllers.record import Rule
from pmwvc_core.errors import ParameterError
from pmwvc_core.params import BaselineParams
from pmwvc_core.scenario.scenario import Scenario, User

RULE, GIVEN = "by its rule", "as given"
IMPEDANCE = "master.impedance"
ALWAYS = (IMPEDANCE, "master.filter.kind", "master.hold", "server.coupling")
SWITCHES = (  # shown with waves where they are on: name, what belongs to it
    ("master.velocity_filter.kind", ("master.velocity_filter.order",)),
    ("master.bank.kind", ("master.local_model.stiffness",)),
    ("master.position.feedback", ("master.position.gain",)),
)


def tuned(scenario: Scenario, *, given: bool = False) -> Scenario:
    """Return the scenario with its baseline tuned for every user.

    One without a tuning rule comes back as it is, as one whose parameters were ``given``.
    """
    rule = record_of(scenario.controller).rule
    if rule is None or given:
        return scenario

    def own(user: User) -> User:
        if getattr(user.baseline, rule.group) != getattr(BaselineParams(), rule.group):
            return user
        params = _proposed(rule, user, scenario)
        if params is None:
            return user
        group: dict[str, Any] = {rule.group: params}
        baseline = dataclasses.replace(user.baseline, **group)
        return dataclasses.replace(user, baseline=baseline)

    return dataclasses.replace(scenario, users=tuple(own(user) for user in scenario.users))


def tuning_of(scenario: Scenario) -> str | None:
    """Return in words a baseline's source of parameters and the rule they miss, or None."""
    rule = record_of(scenario.controller).rule
    if rule is None:
        return None
    ours = all(
        getattr(user.baseline, rule.group) == _proposed(rule, user, scenario)
        for user in scenario.users
    )
    missed: dict[str, float] = {}
    unknown: dict[str, str] = {}
    for user in scenario.users:
        found = rule.check(getattr(user.baseline, rule.group), rule_loop(user, scenario))
        for name, margin in found.criteria.items():
            if math.isnan(margin):
                unknown[name] = f"; rule {name} unknown, as {unknown_delay(user)}"
            elif margin < 0.0:
                missed[name] = min(margin, missed.get(name, 0.0))
    words = RULE if ours else GIVEN
    short = ", ".join(f"{name} by {-margin:.3g} N s/m" for name, margin in missed.items())
    missing = f"; misses {short}" if short else ""
    return "".join([words, missing, *unknown.values()])


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


def _proposed(rule: Rule, user: User, scenario: Scenario) -> Any:
    """Return the parameters by a rule; None where it has no answer, without any damping."""
    try:
        return rule.propose(rule_loop(user, scenario)).params
    except ParameterError:
        return None
