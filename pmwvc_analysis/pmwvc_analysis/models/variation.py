# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Many scenarios as one: a number of the blocks may become a column ``(runs, 1)``.

Whatever decides when things happen (delays, periods, counts, names) is the same for all of them.
"""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from pmwvc_core.numeric import Value
from pmwvc_core.scenario.names import resolved, spec_of
from pmwvc_core.scenario.scenario import Scenario

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


def lengths(scenario: Any) -> Iterator[int]:
    """Yield the lengths of all columns among the parameters."""
    if isinstance(scenario, np.ndarray) and scenario.ndim == 2:
        yield len(scenario)
    elif isinstance(scenario, tuple):
        for each in scenario:
            yield from lengths(each)
    elif dataclasses.is_dataclass(scenario):
        for field in dataclasses.fields(scenario):
            yield from lengths(getattr(scenario, field.name))
