# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From a mapping to a :class:`Scenario`: every mistake found at once, each with path, value, range
and nearest name. Later sources win: the file, its ``userN`` blocks, the overrides. A preset stands
for all settings of a link, or for the impedances of a master; those beside it in a source win.
"""

import re
from collections.abc import Mapping
from typing import Any

from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.network.presets import PRESETS, link_settings
from pmwvc_core.params import Spec, ports, specs
from pmwvc_core.params.names import assembled, flat_mapping, hint
from pmwvc_core.params.server import BLACK_BOX, KNOWN
from pmwvc_core.scenario.names import over_time, resolved
from pmwvc_core.scenario.scenario import PARAMETERS, Scenario, User, prefixed

PRESET_NAME = re.compile(r"(user[1-9]\d*\.|)(?:(master)|link(?:\.\*|\.(up|down)|))\.preset")


def parse_scenario(
    mapping: Mapping[str, Any], *, source: str = "scenario",
    overrides: Mapping[str, Any] | None = None, users: int | None = None,
    duration_s: float | None = None,
) -> Scenario:  # fmt: skip
    """Build a scenario from nested (or dotted) names, ``overrides`` by dotted name, and over these
    the number of ``users`` and ``duration_s`` [s]; ScenarioError listing every mistake of the
    ``source``.
    """
    if not isinstance(mapping, Mapping):
        raise ScenarioError(
            source, [f"{type(mapping).__name__} found where a mapping of names is expected"]
        )
    reader = _Values()
    reader.take(flat_mapping(mapping))
    reader.take(dict(overrides or {}), strict_user=True)
    asked = {"users": users, "duration_s": duration_s}
    reader.take({name: value for name, value in asked.items() if value is not None})
    scenario = reader.build()
    if reader.problems or scenario is None:
        raise ScenarioError(source, reader.problems)
    return scenario


class _Values:
    """Collects values by name, then builds; keeps the list of what is wrong."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self.shared: dict[str, Any] = {}
        self.users: dict[int, dict[str, Any]] = {0: {}}  # by number, 0: for every user

    def take(self, values: Mapping[str, Any], *, strict_user: bool = False) -> None:
        """Sort values into shared and users'; a common override replaces single users'."""
        for name, value in self._without_presets(values).items():
            try:
                number, leaves = resolved(name)
            except ScenarioError as error:
                self.problems.append(f"{name} = {value!r}: {error.problems[0]}")
                continue
            of_user = PARAMETERS[leaves[0]].of_user
            place = self.users.setdefault(number, {}) if of_user else self.shared
            for leaf in leaves:
                self._store(place, leaf, value, name)
                if strict_user and of_user and not number:
                    for user in set(self.users) - {0}:
                        self.users[user].pop(leaf, None)

    def _without_presets(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values with every preset replaced by its settings, before all others."""
        found: dict[str, Any] = {}
        others: dict[str, Any] = {}
        for name, value in values.items():
            match = PRESET_NAME.fullmatch(name)
            user, master, direction = match.groups() if match else ("", "", "")
            known: Mapping[str, Any] = ports.MASTERS if master else PRESETS
            if match is None:
                others[name] = value
            elif problem := Spec(str, choices=tuple(known)).problem(value):
                self.problems.append(f"{name} = {problem}{hint(str(value), known)}")
            else:
                settings = known[value] if master else link_settings(value, direction)
                found |= {f"{user}{path}": setting for path, setting in settings.items()}
        return found | others

    def _store(self, place: dict[str, Any], path: str, value: object, given: str) -> None:
        """Keep a right value; note a wrong one once, and go on with the default."""
        spec = PARAMETERS[path].spec
        value = spec.converted(value)
        if problem := spec.problem(value):
            text = f"{given} = {problem}"
            self.problems += [text] if text not in self.problems else []
        else:
            place[path] = value

    def build(self) -> Scenario | None:
        """Build the scenario; on any mistake add to ``problems`` and return None."""
        if self.shared.get("server.environment", KNOWN[0]) not in KNOWN:
            self.shared.setdefault("server.coupling", BLACK_BOX)
        top = {name: value for name, value in self.shared.items() if name in specs(Scenario)}
        count = top.pop("users", specs(Scenario)["users"].default)
        for number in sorted(n for n in self.users if n > count):
            self.problems.append(f"user{number}: users = {count}; raise users or remove it")
        users = [self._user(number) for number in range(1, count + 1)]
        shared = self._groups(Scenario, self.shared, "")
        parts = (part for owner in (shared, *map(vars, users)) for part in owner.values())
        if any(part is None for part in parts):
            return None
        try:
            scenario = Scenario(users=tuple(users), **shared, **top)
        except ScenarioError as error:
            self.problems += error.problems
            return None
        try:
            over_time(scenario)
        except ParameterError as error:
            self.problems.append(str(error))
        return scenario

    def _user(self, number: int) -> User:
        name = f"user{number}"
        values = self.users[0] | self.users.get(number, {})
        parts = self._groups(User, values, f"{name}.")
        return User(name=name, side=values.get("side", -1 if number % 2 else 1), **parts)

    def _groups(self, owner: type, values: Mapping[str, Any], who: str) -> dict[str, Any]:
        """Return the groups of a scenario or a user by attribute; None where one is wrong."""
        found: dict[str, Any] = {}
        for prefix, (attribute, kind) in prefixed(owner).items():
            try:
                found[attribute] = assembled(prefix, kind, values)
            except ParameterError as error:  # single values are right: this is between two of them
                found[attribute], text = None, str(error)
                if not any(problem.endswith(text) for problem in self.problems):
                    self.problems.append(text if who in ("", "user1.") else who + text)
        return found
