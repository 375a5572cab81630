# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenarios with other numbers, one or many at once, by dotted name.

A number of the blocks may become a column ``(runs, 1)``: then one scenario stands for many. What
decides when things happen (delays, periods, counts, names) is the same for all of them.
"""

import dataclasses
import difflib
import re
from typing import Any

import numpy as np

from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.params import groups, specs
from pmwvc_core.scenario.scenario import (
    SHARED_GROUPS,
    USER_GROUPS,
    Scenario,
    shared_specs,
    user_specs,
)

TIMES = ("delay_s", "tick_s", "period_s")  # numbers that decide when things happen
USER = re.compile(r"user([1-9][0-9]*)\.(.+)")


def stackable(name: str) -> bool:
    """Tell whether a parameter may differ within one scenario, as a column.

    Raises
    ------
    ScenarioError
        If there is no such parameter; names the nearest one.
    """
    leaf = _leaves(name)[0]
    spec = {**shared_specs(), **user_specs()}[leaf]
    return spec.kind is float and leaf.rpartition(".")[2] not in TIMES and "." in leaf


def varied(scenario: Scenario, name: str, value: Any) -> Scenario:
    """Return the scenario with a parameter changed.

    Parameters
    ----------
    scenario
        The others.
    name
        As for ``--set``: ``server.contact_stiffness``, ``link.delay_s`` (both ways),
        ``user2.device.mass`` (one user; without ``user2.`` all users).
    value
        A plain value, or a column ``(runs, 1)`` for a stackable name.

    Raises
    ------
    ScenarioError
        If there is no such parameter, or it may not have that value.
    """
    single = USER.fullmatch(name)
    changed = scenario
    for leaf in _leaves(name):
        prefix = max((p for p in _prefixes() if leaf.startswith(p + ".")), key=len, default="")
        try:
            changed = _changed(changed, leaf, prefix, value, int(single[1]) if single else 0)
        except ScenarioError:
            raise
        except ParameterError as error:
            raise ScenarioError(
                scenario.name, [f"{prefix}.{error}" if prefix else str(error)]
            ) from None
    return changed


def with_stiffness(scenario: Scenario, stiffness: Any) -> Scenario:
    """Return the scenario with other contact stiffnesses, a column ``(runs, 1)`` [N/m].

    It is that of the stiffest contact; where users differ, they keep their proportion.
    """
    values = [float(np.max(user.contact.contact_stiffness)) for user in scenario.users]
    top = max(values)
    users = [
        dataclasses.replace(
            user,
            contact=dataclasses.replace(
                user.contact, contact_stiffness=stiffness * (value / top if top > 0.0 else 1.0)
            ),
        )
        for user, value in zip(scenario.users, values, strict=True)
    ]
    return dataclasses.replace(scenario, users=tuple(users))


def value_of(scenario: Scenario, name: str) -> float | None:
    """Return a number of a scenario: that of the first user where several are meant; None where
    it has none.
    """
    single = USER.fullmatch(name)
    place = int(single[1]) - 1 if single else 0
    if place >= len(scenario.users):
        raise ScenarioError(scenario.name, [f"{name}: there is no user{place + 1}"])
    user = scenario.users[place]
    leaf = _leaves(name)[0]
    for groups_of, source in ((USER_GROUPS, user), (SHARED_GROUPS, scenario)):
        for prefix, (attribute, kind) in groups_of.items():
            path = leaf.removeprefix(prefix + ".")
            if path != leaf and _has(kind, path):
                owner: Any = getattr(source, attribute)
                for part in path.split("."):
                    owner = getattr(owner, part)
                return None if owner is None or isinstance(owner, str) else float(owner)
    return None


def _prefixes() -> set[str]:
    return {*USER_GROUPS, *SHARED_GROUPS}


def _leaves(name: str) -> list[str]:
    """Return the full names meant, without the user."""
    single = USER.fullmatch(name)
    rest = single[2] if single else name
    known = user_specs() if single else {**shared_specs(), **user_specs()}
    if rest in known:
        return [rest]
    head, _, tail = rest.partition(".")
    both = [f"{head}.{way}.{tail}" for way in ("up", "down")]
    if all(leaf in known for leaf in both):
        return both
    near = difflib.get_close_matches(rest, [*known, "link.delay_s"], n=1)
    hint = f"; did you mean {near[0]}?" if near else ""
    raise ScenarioError(name, [f"there is no such parameter{hint}"])


def _has(kind: type, path: str) -> bool:
    head, _, rest = path.partition(".")
    nested = groups(kind)
    return _has(nested[head], rest) if rest and head in nested else path in specs(kind)


def _changed(scenario: Scenario, leaf: str, prefix: str, value: Any, number: int) -> Scenario:
    path = leaf[len(prefix) + 1 :].split(".")
    if number > len(scenario.users):
        raise ParameterError(f"{leaf}: there is no user{number}")
    if prefix in USER_GROUPS and _has(USER_GROUPS[prefix][1], ".".join(path)):
        attribute = USER_GROUPS[prefix][0]
        users = [
            dataclasses.replace(user, **{attribute: _set(getattr(user, attribute), path, value)})
            if number in (0, place)
            else user
            for place, user in enumerate(scenario.users, start=1)
        ]
        return dataclasses.replace(scenario, users=tuple(users))
    if prefix not in SHARED_GROUPS:
        raise ParameterError(f"{leaf}: decides what a scenario is; make two scenarios")
    attribute = SHARED_GROUPS[prefix][0]
    owner = _set(getattr(scenario, attribute), path, value)
    changes: dict[str, Any] = {attribute: owner}
    return dataclasses.replace(scenario, **changes)


def _set(owner: Any, path: list[str], value: Any) -> Any:
    if len(path) > 1:
        value = _set(getattr(owner, path[0]), path[1:], value)
    elif specs(owner)[path[0]].kind is int and isinstance(value, float) and value == int(value):
        value = int(value)
    return dataclasses.replace(owner, **{path[0]: value})
