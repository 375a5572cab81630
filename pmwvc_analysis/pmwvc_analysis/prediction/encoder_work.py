# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy that a device gives out behind an encoder whose differences are its velocity, on the
strict channel.

Condition and amount are those of :mod:`pmwvc_core.master.count_bound`, which needs a hand on the
device. Whatever the condition says, a scenario without a person is simulated for its first
``LONGEST_S``, and the work judged by the true motion.
"""

import dataclasses
import functools

from pmwvc_analysis.budget.counts import behind_counts, held
from pmwvc_analysis.budget.energy import declared, user_energies
from pmwvc_core.errors import PmwvcError
from pmwvc_core.master.count_bound import count_bound
from pmwvc_core.quantities import quantity
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.session import simulate_one

LONGEST_S = 6.0
BY_PEOPLE = ("remote", "none")  # operators whose force is a person's
LEAST_J = 1e-6  # what every port is judged with


def encoder_lines(scenario: Scenario) -> list[str]:
    """Return in words what the ports behind such encoders give out; nothing without one."""
    users = [user for user in scenario.users if behind_counts(user, scenario)]
    return [_line(user, scenario) for user in users]


def _line(user: User, scenario: Scenario) -> str:
    bound = count_bound(user.master, user.device)
    words = f"{user.name}: {bound.text()}"
    if not held(user):
        kind = user.operator.kind
        words += f" Without an arm on the device (operator.kind = {kind}) no bound is known."
    given_j = None
    if user.device.is_simulated and user.operator.kind not in BY_PEOPLE:
        given_j = _given_j(scenario).get(user.name)
    if given_j is None:
        return f"{words} This session is not simulated beforehand."
    shown = f"Simulated for {_short(scenario).duration_s:g} s, the port of the hand"
    if given_j <= LEAST_J:
        return f"{words} {shown} is passive."
    bound_j = bound.given_j if bound.holds and held(user) else 0.0
    if given_j <= bound_j:
        return f"{words} {shown} gives out up to {quantity(given_j, 'J')}, within that bound."
    return (
        f"Warning: {words} {shown} gives out up to {quantity(given_j, 'J')} more than it took in. "
        "A velocity of the device's own, a finer encoder or a smaller master.impedance gives less."
    )


def _short(scenario: Scenario) -> Scenario:
    return dataclasses.replace(scenario, duration_s=min(scenario.duration_s, LONGEST_S))


@functools.lru_cache(maxsize=4)
def _given_j(scenario: Scenario) -> dict[str, float]:
    """Return what every port of a hand gave out beyond what it took in and its controller was lent
    [J]; none where the scenario cannot be simulated.
    """
    short = _short(scenario)
    try:
        energies = user_energies(simulate_one(short), short)
    except PmwvcError:  # a file or plug-in that a recorded session had
        return {}
    lent_j = {user.name: declared(short, user).controller_j for user in short.users}
    return {each.name: -each.joint.minimum_j - lent_j[each.name] for each in energies}
