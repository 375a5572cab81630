# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of each controller in a comparison, and the tuning rules that they miss."""

import math
from typing import Any

from pmwvc_analysis.prediction.text import rule_margins, unknown_delay
from pmwvc_core.controllers.library import record_of
from pmwvc_core.scenario.names import spec_of, split_user
from pmwvc_core.scenario.scenario import Scenario

ALWAYS = ("master.impedance", "master.filter.kind", "master.hold", "server.coupling")


def tuning_of(scenario: Scenario) -> str | None:
    """Return in words how a baseline's parameters meet its rules, the worst user of each; None for
    a controller without a rule.
    """
    if record_of(scenario.controller).rule is None:
        return None
    missed: dict[str, float] = {}
    unknown: dict[str, str] = {}
    for user in scenario.users:
        for name, margin in rule_margins(user, scenario).items():
            if math.isnan(margin):
                unknown[name] = f"rule {name} unknown, as {unknown_delay(user)}"
            elif margin < 0.0:
                missed[name] = min(margin, missed.get(name, 0.0))
    words = [f"misses rule {name} by {-margin:.3g} N s/m" for name, margin in missed.items()]
    return "; ".join([*words, *unknown.values()]) or "meets its rules"


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
