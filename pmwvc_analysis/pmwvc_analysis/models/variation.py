# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Many scenarios as one: a number of the blocks may become a column ``(runs, 1)``.

Whatever decides when things happen (delays, periods, counts, names) is the same for all of them.
"""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array, Value
from pmwvc_core.scenario.names import resolved, spec_of
from pmwvc_core.scenario.scenario import Scenario, User

Path = tuple[Any, ...]
TIMES = ("delay_s", "tick_s", "period_s")  # numbers that decide when things happen


def stackable(name: str) -> bool:
    """Tell whether a parameter may differ within one scenario, as a column.

    Raises
    ------
    ScenarioError
        If there is no such parameter; names the nearest one.
    """
    group, _, leaf = resolved(name)[1][0].rpartition(".")
    return bool(group) and spec_of(name).kind is float and leaf not in TIMES


def with_stiffness(scenario: Scenario, stiffness: Value) -> Scenario:
    """Return the scenario with other contact stiffnesses, a column ``(runs, 1)`` [N/m].

    It is that of the stiffest contact; where users differ, they keep their proportion.
    """
    values = [float(np.max(user.contact.contact_stiffness)) for user in scenario.users]
    top = max(values)
    users = [
        dataclasses.replace(
            user,
            contact=dataclasses.replace(
                user.contact,
                contact_stiffness=stiffness * (value / top if top > 0.0 else 1.0),  # type: ignore[arg-type]
            ),
        )
        for user, value in zip(scenario.users, values, strict=True)
    ]
    return dataclasses.replace(scenario, users=tuple(users))


def with_impedances(user: User, master: float, server: float | None) -> User:
    """Return a user with numbers as impedances of both ends, None: that of the other [N s/m]."""
    none: dict[str, Any] = {"impedance_matrix": ""}
    return dataclasses.replace(
        user,
        master=dataclasses.replace(user.master, impedance=master, **none),
        contact=dataclasses.replace(user.contact, impedance=server, **none),
    )


def lengths(scenario: Any) -> Iterator[int]:
    """Yield the lengths of all columns among the parameters."""
    return (len(column) for _, column in _columns(scenario))


def runs_of(scenario: Scenario) -> list[Scenario]:
    """Return the scenarios that columns stand for, one by one."""
    columns = list(_columns(scenario))
    if not columns:
        return [scenario]
    runs = max(len(column) for _, column in columns)
    rows = [np.broadcast_to(column[:, 0], runs).tolist() for _, column in columns]
    paths = [path for path, _ in columns]
    return [
        _with(scenario, dict(zip(paths, values, strict=True)))
        for values in zip(*rows, strict=True)
    ]


def _columns(value: Any, path: Path = ()) -> Iterator[tuple[Path, Array]]:
    """Yield the columns among the parameters, with their paths."""
    if isinstance(value, np.ndarray) and value.ndim == 2:
        yield path, value
    elif isinstance(value, tuple):
        for index, each in enumerate(value):
            yield from _columns(each, (*path, index))
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from _columns(getattr(value, field.name), (*path, field.name))


def _with(value: Any, numbers: dict[Path, float]) -> Any:
    """Return parameters with other numbers at some paths."""
    if () in numbers:
        return numbers[()]
    of: dict[Any, dict[Path, float]] = {}
    for (first, *rest), number in numbers.items():
        of.setdefault(first, {})[tuple(rest)] = number
    if isinstance(value, tuple):
        return tuple(_with(each, of[i]) if i in of else each for i, each in enumerate(value))
    new = {name: _with(getattr(value, name), inside) for name, inside in of.items()}
    return dataclasses.replace(value, **new)
