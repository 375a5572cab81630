# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenarios with other numbers, which are stepped side by side where they do not differ in what
decides when things happen (delays, periods, counts, names).
"""

from collections.abc import Sequence
from typing import Any, TypeVar

from pmwvc_core.scenario.names import resolved, spec_of
from pmwvc_core.scenario.scenario import PARAMETERS, Scenario, User

TIMES = ("delay_s", "tick_s", "period_s")  # numbers that decide when things happen
T = TypeVar("T")


def stackable(name: str) -> bool:
    """Tell whether a parameter may differ side by side; ScenarioError where there is none."""
    group, _, leaf = resolved(name)[1][0].rpartition(".")
    return bool(group) and spec_of(name).kind is float and leaf not in TIMES


def changed(parameters: T, **values: Any) -> T:
    """Return parameters with other values, which need no check."""
    found = object.__new__(type(parameters))
    vars(found).update(vars(parameters) | values)
    return found


def with_value(scenario: Scenario, name: str, value: float) -> Scenario:
    """Return the scenario with another value of a parameter, which needs no check."""
    number, leaves = resolved(name)
    for leaf in leaves:
        _, path, of_user = PARAMETERS[leaf]
        names = path.split(".")
        if not of_user:
            scenario = _with(scenario, names, value)
            continue
        users = [
            _with(user, names, value) if number in (0, index) else user
            for index, user in enumerate(scenario.users, start=1)
        ]
        scenario = changed(scenario, users=tuple(users))
    return scenario


def _with(group: Any, names: Sequence[str], value: float) -> Any:
    first, *others = names
    return changed(
        group, **{first: _with(getattr(group, first), others, value) if others else value}
    )


def with_stiffness(scenario: Scenario, stiffness: float) -> Scenario:
    """Return the scenario with another stiffness [N/m] of the stiffest contact, the others in
    proportion.
    """
    values = [float(user.contact.contact_stiffness) for user in scenario.users]
    users, top = [], max(values)
    for user, value in zip(scenario.users, values, strict=True):
        own = float(stiffness) * (value / top if top > 0.0 else 1.0)
        users.append(changed(user, contact=changed(user.contact, contact_stiffness=own)))
    return changed(scenario, users=tuple(users))


def with_impedances(user: User, master: float, server: float | None) -> User:
    """Return a user with numbers as impedances of both ends, None: that of the other [N s/m]."""
    none: dict[str, Any] = {"impedance_matrix": ""}
    return changed(
        user,
        master=changed(user.master, impedance=master, **none),
        contact=changed(user.contact, impedance=server, **none),
    )
