# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session in virtual time, with the scenario's own hands, by which a choice is judged."""

import dataclasses

from pmwvc_analysis.models.linear import axes_of
from pmwvc_analysis.tune.criteria import Rating
from pmwvc_analysis.verdicts import passivity_words
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one

STABLE, NOT_JUDGED = "stable", "stability not judged"
LEAST_S, LONGEST_S = 4.0, 12.0
USER_TICKS = 48_000  # that may be simulated: some 1 s
COUPLED = 8  # of them for a tick with axes that are coupled


def session_of(scenario: Scenario) -> Scenario | None:
    """Return the session that a choice is judged by; None where that is too much work.

    Axes that no matrix couples are equal: the one along which the hands press stands for them.
    """
    if axes_of(scenario) == 1:
        task = dataclasses.replace(scenario.task, sideways_m=0.0)
        scenario = dataclasses.replace(scenario, dof=1, task=task)
    ticks = USER_TICKS / len(scenario.users) / (COUPLED if scenario.dof > 1 else 1)
    longest_s = min(LONGEST_S, ticks * scenario.tick_s)
    if longest_s < min(LEAST_S, scenario.duration_s):
        return None
    return dataclasses.replace(scenario, duration_s=min(scenario.duration_s, longest_s))


def judged(scenario: Scenario, row: Rating) -> Rating:
    """Return the rating of a choice with the verdicts of its session in virtual time."""
    session = session_of(row.choice.applied(scenario))
    if session is None:
        return row
    stable, not_passive = _verdicts(session)
    return dataclasses.replace(row, simulated=stable, simulated_passivity=not_passive)


def _verdicts(short: Scenario) -> tuple[str, str | None]:
    """Return the verdict on stability of a session in virtual time, and that on passivity where a
    port was not passive.
    """
    traces = simulate_one(short)
    found = verdict(traces, short)
    ports = passivity(traces, short, None)
    owners = dict.fromkeys(each.owner for each in ports.findings if each.passive is False)
    words = [f"{owner}: {passivity_words.verdict(ports, owner)}" for owner in owners]
    stable = STABLE if found.stable else found.instability or NOT_JUDGED
    return stable, "; ".join(words) or None
