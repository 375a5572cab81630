# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Many scenarios as one batch: equal structure, different numbers.

Numbers that differ between scenarios become arrays ``(runs, 1)``; everything that decides which
code runs and when (names, counts, periods, the task's times) is the structure and must agree
within a batch.
"""

import dataclasses
from collections.abc import Hashable, Sequence
from functools import lru_cache
from typing import TypeVar

import numpy as np

from pmwvc_core.network.effects import is_random
from pmwvc_core.params.names import assembled, flattened, leaves
from pmwvc_core.scenario.scenario import USER_GROUPS, Scenario

P = TypeVar("P")
# Numbers that decide when things happen, or that are read once per run rather than per tick.
STRUCTURAL = {
    "tick_s",
    "period_s",
    "fade_s",
    "rate_hz",
    "scale",
    "offset",
    "sweep_s",
    "timeout_s",
    "soft_start_s",
    "release_s",
}


def structure_of(scenario: Scenario) -> Hashable:
    """Return what must agree for two scenarios to be stepped together."""
    users = tuple(
        (
            user.name,
            user.side,
            *(
                _structure(getattr(user, attribute))
                for attribute, _ in USER_GROUPS.values()
                if not attribute.startswith("link")
            ),
            user.link_up,
            user.link_down,
        )
        for user in scenario.users
    )
    random = any(
        is_random(link) for user in scenario.users for link in (user.link_up, user.link_down)
    )
    deadband = any(
        end.deadband.is_on for user in scenario.users for end in (user.master, user.contact)
    )
    return (
        scenario if deadband else None,  # which packets are sent depends on every number
        scenario.seed if random else None,
        scenario.duration_s,
        scenario.controller,
        scenario.channel,
        scenario.dof,
        scenario.changes,
        _structure(scenario.server),
        scenario.task,
        users,
    )


@lru_cache(maxsize=1024)  # runs of a study share most of their groups
def _structure(owner: Hashable) -> Hashable:
    """Return the values of one parameter group that belong to the structure."""
    declared = leaves("", owner)
    return tuple(
        value if declared[name].kind is not float or name in STRUCTURAL else value is None
        for name, value in flattened("", owner).items()
    )


def stack(items: Sequence[P]) -> P:
    """Join parameter groups of equal structure: a number that differs becomes an array ``(runs,
    1)``.

    Raises
    ------
    ValueError
        If something else than a number differs.
    """
    first = items[0]
    if all(item == first for item in items):
        return first
    each = [flattened("", item) for item in items]
    changes = {}
    for name, spec in leaves("", first).items():
        values = [one[name] for one in each]
        if all(value == values[0] for value in values):
            continue
        if spec.kind is not float or None in values:
            raise ValueError(f"{name} differs within a batch: {sorted(map(str, set(values)))}")
        changes[name] = np.asarray(values, dtype=float)[:, np.newaxis]
    return assembled("", type(first), each[0] | changes) if changes else first


def stack_scenarios(scenarios: Sequence[Scenario]) -> Scenario:
    """Join scenarios of equal structure; see :func:`stack`."""
    first = scenarios[0]
    if len(scenarios) == 1:
        return first
    groups_of_user = [attribute for attribute, _ in USER_GROUPS.values()]
    users = tuple(
        dataclasses.replace(
            user,
            **{
                attribute: stack([getattr(s.users[i], attribute) for s in scenarios])
                for attribute in groups_of_user
            },
        )
        for i, user in enumerate(first.users)
    )
    return dataclasses.replace(first, users=users, server=stack([s.server for s in scenarios]))


def batches(scenarios: Sequence[Scenario], *, smallest: int, largest: int) -> list[list[int]]:
    """Return the positions of scenarios that are stepped together, at most ``largest`` at once;
    fewer than ``smallest`` of one axis are stepped one by one.
    """
    by_structure: dict[Hashable, list[int]] = {}
    for position, scenario in enumerate(scenarios):
        by_structure.setdefault(structure_of(scenario), []).append(position)
    found = []
    for members in by_structure.values():
        alone = len(members) < smallest and scenarios[members[0]].dof == 1
        size = 1 if alone else largest
        found += [members[start : start + size] for start in range(0, len(members), size)]
    return found
