# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From a mapping to a :class:`Scenario`: every mistake found at once, each with path, value, range
and nearest name.

``link.delay_s`` (directly below ``link``) means both directions; ``user2.`` in front of a name
means that user only. Later sources win: the file, then its ``userN`` blocks, then the overrides.
``link.preset`` stands for all settings of a link; settings of the same source beside it win.
"""

import re
from collections.abc import Mapping
from typing import Any

from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.network.presets import PRESETS, link_settings
from pmwvc_core.params import Spec, specs
from pmwvc_core.params.names import assembled, flat_mapping, hint
from pmwvc_core.scenario import changes
from pmwvc_core.scenario.names import complete, shared_specs, split_user, unknown, user_specs
from pmwvc_core.scenario.scenario import (
    DEFAULTS,
    REQUIRED,
    SHARED_GROUPS,
    TOP,
    USER_GROUPS,
    Scenario,
    User,
)

# Stand in for a required value that is wrong, so that the rest can still be checked.
PLACEHOLDERS = {"name": "?", "duration_s": 1.0, "controller": "pmwvc", "users": 8}
PRESET_NAME = re.compile(r"(user[1-9][0-9]*\.)?link\.(?:\*\.|(up|down)\.)?preset")
PRESET = Spec(str, description="network by name", choices=tuple(PRESETS))

# Recordings of before have it: links did as tc-netem with another value.
GONE = re.compile(r"link\.(up\.|down\.)?mode")


def parse_scenario(
    mapping: Mapping[str, Any],
    *,
    source: str = "scenario",
    overrides: Mapping[str, Any] | None = None,
    users: int | None = None,
    duration_s: float | None = None,
) -> Scenario:
    """Build a scenario from nested (or dotted) names; ScenarioError, with its ``source``, listing
    every mistake of the file and the overrides.

    Over the file win ``overrides`` (``--set``, values by dotted name), and over these the number
    of ``users`` and ``duration_s`` [s].
    """
    if not isinstance(mapping, Mapping):
        raise ScenarioError(
            source, [f"{type(mapping).__name__} found where a mapping of names is expected"]
        )
    reader = _Reader()
    reader.take(flat_mapping(mapping))
    reader.take(dict(overrides or {}), strict_user=True)
    if users is not None:
        reader.take({"users": users})
    if duration_s is not None:
        reader.take({"duration_s": duration_s})
    scenario = reader.build()
    if reader.problems or scenario is None:
        raise ScenarioError(source, reader.problems)
    return scenario


def _converted(spec: Spec, value: object) -> object:
    """Return the value in the declared type where that loses nothing; else as it is, to be refused
    with its text.
    """
    if spec.kind is float and isinstance(value, str):  # YAML 1.1 reads 1e-3 (no dot) as a text
        try:
            return float(value)
        except ValueError:
            return value
    if spec.kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if spec.kind is int and isinstance(value, float) and value.is_integer():
        return int(value)
    if spec.kind is str and value is None:  # a name with nothing behind it: an empty text
        return ""
    if spec.kind is str and type(value) is int:  # the number of a column is a text to us
        return str(value)
    return value


class _Reader:
    """Collects values by name, then builds; keeps the list of what is wrong."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self.user_specs = user_specs()
        self.shared_specs = shared_specs()
        self.shared: dict[str, Any] = {}
        self.common: dict[str, Any] = {}  # for every user
        self.single: dict[int, dict[str, Any]] = {}  # for one user, by number

    def take(self, values: Mapping[str, Any], *, strict_user: bool = False) -> None:
        """Sort values into shared, common and single; a common override replaces what single users
        had.
        """
        for name, value in self._without_presets(values).items():
            number, rest = split_user(name)
            leaves = complete(rest)
            if number and leaves and all(leaf in self.user_specs for leaf in leaves):
                own = self.single.setdefault(number, {})
                for leaf in leaves:
                    given = name if len(leaves) > 1 else f"user{number}.{leaf}"
                    self._store(own, leaf, self.user_specs[leaf], value, given)
            elif not number and len(leaves) == 1 and leaves[0] in self.shared_specs:
                self._store(self.shared, rest, self.shared_specs[rest], value, rest)
            elif not number and leaves and leaves[0] in self.user_specs and leaves[0] != "side":
                for leaf in leaves:
                    given = name if len(leaves) > 1 else leaf
                    self._store(self.common, leaf, self.user_specs[leaf], value, given)
                    if strict_user:
                        for own in self.single.values():
                            own.pop(leaf, None)
            elif not (GONE.fullmatch(rest) and value == "exact"):
                self._refuse(name, value, number, rest)

    def _without_presets(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values with every preset replaced by its settings, before all others."""
        found: dict[str, Any] = {}
        others: dict[str, Any] = {}
        for name, value in values.items():
            match = PRESET_NAME.fullmatch(name)
            if match is None:
                others[name] = value
            elif problem := PRESET.problem(value):
                self.problems.append(f"{name} = {problem}{hint(str(value), PRESETS)}")
            else:
                user, direction = match[1] or "", match[2]
                settings = link_settings(value, (direction,) if direction else ("up", "down"))
                found |= {f"{user}{path}": setting for path, setting in settings.items()}
        return found | others

    def _store(
        self, place: dict[str, Any], path: str, spec: Spec, value: object, given: str
    ) -> None:
        """Keep a right value; note a wrong one, under the name that was given, once, and go on
        with the default to find what else is wrong.
        """
        value = _converted(spec, value)
        problem = spec.problem(value)
        if problem:
            text = f"{given} = {problem}"
            self.problems += [text] if text not in self.problems else []
            value = PLACEHOLDERS.get(path)
        if not problem or value is not None:
            place[path] = value

    def _refuse(self, name: str, value: Any, number: int, rest: str) -> None:
        text = unknown(name)
        if number and rest in self.shared_specs:
            text = f"{rest} is shared by all users; set it without user{number}"
        self.problems.append(f"{name} = {value!r}: {text}")

    def build(self) -> Scenario | None:
        """Build the scenario; on any mistake add to ``problems`` and return None."""
        for name in REQUIRED:
            if name not in self.shared:
                self.problems.append(f"{name} is missing: must be {TOP[name].range_text()}")
        top = {**DEFAULTS, **{k: v for k, v in self.shared.items() if k in TOP}}
        count = top.get("users")
        if isinstance(count, int):
            for number in sorted(n for n in self.single if n > count):
                self.problems.append(f"user{number}: users = {count}; raise users or remove it")
        if count is None:
            return None
        users = [self._user(number) for number in range(1, count + 1)]
        shared = {
            attribute: self._built(prefix, kind, self.shared, "")
            for prefix, (attribute, kind) in SHARED_GROUPS.items()
        }
        if any(name not in top for name in REQUIRED) or None in shared.values():
            return None
        if any(part is None for user in users for part in vars(user).values()):
            return None
        top.pop("users")
        try:
            scenario = Scenario(users=tuple(users), **shared, **top)
        except ScenarioError as error:
            self.problems += error.problems
            return None
        self.problems += changes.problems(scenario)
        return scenario

    def _user(self, number: int) -> User:
        name = f"user{number}"
        values = self.common | self.single.get(number, {})
        parts = {
            attribute: self._built(prefix, kind, values, f"{name}.")
            for prefix, (attribute, kind) in USER_GROUPS.items()
        }
        side = values.get("side", -1 if number % 2 else 1)
        if side == 0:
            self.problems.append(f"{name}.side = 0: must be -1 or 1")
        return User(name=name, side=side, **parts)

    def _built(self, prefix: str, kind: type, values: Mapping[str, Any], who: str) -> Any:
        try:
            return assembled(prefix, kind, values, named=_named_in_full)
        except ParameterError as error:  # single values are right: this is between two of them
            text = str(error)
            if not any(problem.endswith(text) for problem in self.problems):
                self.problems.append(text if who in ("", "user1.") else who + text)
            return None


def _named_in_full(text: str, prefix: str, kind: type) -> str:
    """Return conflicts of a group with the full name of every parameter that begins one."""
    names = "|".join(specs(kind))
    named = re.sub(rf"(^|; )(?=({names}) = )", rf"\1{prefix}.", text)
    return named if named.startswith(f"{prefix}.") else f"{prefix}: {named}"
