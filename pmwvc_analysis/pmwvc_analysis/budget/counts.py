# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The users behind an encoder whose differences are the velocity, on the strict channel, and what
the port of their hand is bounded to give out (:mod:`pmwvc_core.master.count_bound`).
"""

from pmwvc_analysis.traces.stages import stages
from pmwvc_core.master.count_bound import CountBound, count_bound
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import SessionTraces


def behind_counts(user: User, scenario: Scenario) -> bool:
    """Tell whether a user's waves come of the differences of an encoder's counts."""
    device = user.device
    return scenario.strict and device.differences and bool(device.encoder_step_m > 0.0)


def held(user: User) -> bool:
    """Tell whether a hand is on the device: a person's, or an arm that is simulated."""
    return not user.device.is_simulated or user.operator.has_arm


def bounded(user: User, scenario: Scenario) -> CountBound | None:
    """Return what a port behind counts is promised to give out at most; None where nothing is."""
    if not behind_counts(user, scenario) or not held(user):
        return None
    bound = count_bound(user.master, user.device)
    return bound if bound.holds else None


def counts_j(traces: SessionTraces, scenario: Scenario | None, name: str) -> float:
    """Return what a user's port behind counts may give out at most in a session [J]; zero where no
    bound held all the time.
    """
    if scenario is None:
        return 0.0
    found = [
        bounded(user, stage.scenario)
        for stage in stages(traces, scenario)
        for user in stage.scenario.users
        if user.name == name
    ]
    return min((bound.given_j if bound else 0.0 for bound in found), default=0.0)
