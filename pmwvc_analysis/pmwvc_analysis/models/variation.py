# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Many scenarios as one: a number of the blocks may become a column ``(runs, 1)``.

Whatever decides when things happen (delays, periods, counts, names) is the same for all of them.
"""

import copy
import dataclasses
from typing import Any

import numpy as np

from pmwvc_core.numeric import Value
from pmwvc_core.scenario.names import resolved, spec_of
from pmwvc_core.scenario.scenario import Scenario, User

TIMES = ("delay_s", "tick_s", "period_s")  # numbers that decide when things happen


def stackable(name: str) -> bool:
    """Tell whether a parameter may differ within one scenario, as a column; ScenarioError if there
    is none, with the nearest name.
    """
    group, _, leaf = resolved(name)[1][0].rpartition(".")
    return bool(group) and spec_of(name).kind is float and leaf not in TIMES


def with_stiffness(scenario: Scenario, stiffness: Value) -> Scenario:
    """Return the scenario with other contact stiffnesses, a column ``(runs, 1)`` [N/m].

    It is that of the stiffest contact; where users differ, they keep their proportion.
    """
    values = [float(np.max(user.contact.contact_stiffness)) for user in scenario.users]
    users, top = [], max(values)
    for user, value in zip(scenario.users, values, strict=True):
        own: Any = stiffness * (value / top if top > 0.0 else 1.0)
        contact = dataclasses.replace(user.contact, contact_stiffness=own)
        users.append(dataclasses.replace(user, contact=contact))
    return dataclasses.replace(scenario, users=tuple(users))


def with_impedances(user: User, master: float, server: float | None) -> User:
    """Return a user with numbers as impedances of both ends, None: that of the other [N s/m]."""
    none: dict[str, Any] = {"impedance_matrix": ""}
    return dataclasses.replace(
        user,
        master=dataclasses.replace(user.master, impedance=master, **none),
        contact=dataclasses.replace(user.contact, impedance=server, **none),
    )


def lengths(scenario: Scenario) -> list[int]:
    """Return the lengths of all columns among the parameters."""
    found, left = [], [_columns(scenario)]
    while left:
        columns = left.pop()
        if isinstance(columns, dict):
            left += columns.values()
        elif columns is not None:
            found.append(len(columns))
    return found


def runs_of(scenario: Scenario) -> list[Scenario]:
    """Return the scenarios that columns stand for, one by one."""
    columns, runs = _columns(scenario), max(lengths(scenario), default=0)
    return [_run(scenario, columns, run) for run in range(runs)] or [scenario]


def _columns(value: Any) -> Any:
    """Return the columns among parameters, by their names or numbers there; None: there are
    none.
    """
    if isinstance(value, np.ndarray) and value.ndim == 2:
        return value
    parts: dict[Any, Any] = {}
    if isinstance(value, tuple):
        parts = dict(enumerate(value))
    elif dataclasses.is_dataclass(value):
        parts = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    found = {name: _columns(part) for name, part in parts.items()}
    return {name: column for name, column in found.items() if column is not None} or None


def _run(value: Any, columns: Any, run: int) -> Any:
    """Return parameters with the numbers of a run in place of columns."""
    if not isinstance(columns, dict):
        return float(columns[run % len(columns), 0])  # as broadcast
    if isinstance(value, tuple):
        pairs = enumerate(value)
        return tuple(_run(each, columns[i], run) if i in columns else each for i, each in pairs)
    found = copy.copy(value)  # its numbers were checked as columns
    for name, inside in columns.items():
        vars(found)[name] = _run(getattr(value, name), inside, run)
    return found
