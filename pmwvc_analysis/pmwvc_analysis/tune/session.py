# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session in virtual time, with the scenario's own hands, by which a choice is judged."""

import dataclasses

from pmwvc_analysis.tune.criteria import Rating
from pmwvc_analysis.verdicts import passivity_words
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one

STABLE, NOT_JUDGED = "stable", "stability not judged"
LONGEST_S = 12.0


def judged(scenario: Scenario, row: Rating) -> Rating:
    """Return the rating of a choice with the verdicts of its session in virtual time."""
    stable, not_passive = _verdicts(row.choice.applied(scenario))
    return dataclasses.replace(row, simulated=stable, simulated_passivity=not_passive)


def _verdicts(scenario: Scenario) -> tuple[str, str | None]:
    """Return the verdict on stability of a session in virtual time, and that on passivity where a
    port was not passive.
    """
    short = dataclasses.replace(scenario, duration_s=min(scenario.duration_s, LONGEST_S))
    traces = simulate_one(short)
    found = verdict(traces, short)
    ports = passivity(traces, short, None)
    owners = dict.fromkeys(each.owner for each in ports.findings if each.passive is False)
    words = [f"{owner}: {passivity_words.verdict(ports, owner)}" for owner in owners]
    stable = STABLE if found.stable else found.instability or NOT_JUDGED
    return stable, "; ".join(words) or None
