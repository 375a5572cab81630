# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The dotted names of a scenario's parameters: declared, resolved, read and changed in one place.

``server.contact_stiffness`` means every user; ``user2.device.mass`` means that user only;
``link.delay_s`` and ``link.*.delay_s`` mean both directions. Names within one dataclass:
:mod:`pmwvc_core.params.names`.
"""

import dataclasses
import functools
import re
from collections.abc import Mapping
from operator import attrgetter
from typing import NamedTuple

from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.params import LinkParams, Spec, specs
from pmwvc_core.params.names import hint, joined, leaves, replaced
from pmwvc_core.scenario.scenario import SHARED_GROUPS, SIDE, TOP, USER_GROUPS, Scenario

SYMBOL = 2  # letters of a symbol of the equations, at most
USER_NAME = re.compile(r"user([1-9][0-9]*)\.(.+)")


class Home(NamedTuple):
    """Home of a parameter: its path of attributes from a user or from the scenario on."""

    path: str
    of_user: bool


@functools.cache
def user_specs() -> Mapping[str, Spec]:
    """Return the declarations of all that a user has for itself, by name without the user."""
    found = {"side": SIDE}
    for prefix, (_, kind) in USER_GROUPS.items():
        found |= leaves(prefix, kind)
    return found


@functools.cache
def shared_specs() -> Mapping[str, Spec]:
    """Return the declarations of all that users share, by name."""
    found = dict(TOP)
    for prefix, (_, kind) in SHARED_GROUPS.items():
        found |= leaves(prefix, kind)
    return found


@functools.cache
def homes() -> Mapping[str, Home]:
    """Return where every parameter of a group is, by complete name."""
    return {
        joined(prefix, path): Home(f"{attribute}.{path}", of_user)
        for of_user, groups in ((False, SHARED_GROUPS), (True, USER_GROUPS))
        for prefix, (attribute, kind) in groups.items()
        for path in leaves("", kind)
    }


def split_user(name: str) -> tuple[int, str]:
    """Return the number of the user that a name begins with (0: none), and the rest."""
    match = USER_NAME.fullmatch(name)
    return (int(match[1]), match[2]) if match else (0, name)


def complete(name: str) -> list[str]:
    """Return the complete names that a name without user means; none for an unknown one."""
    short = name.removeprefix("link.").removeprefix("*.")
    if name.startswith("link.") and short in specs(LinkParams):
        return [f"link.up.{short}", f"link.down.{short}"]
    return [name] if name in user_specs() or name in shared_specs() else []


def unknown(name: str) -> str:
    """Return the refusal of a name that there is not, with the nearest one, or the one whose
    description has that symbol.
    """
    number, rest = split_user(name)
    known = {**user_specs(), **({} if number else shared_specs())}
    symbols = [
        path
        for path, spec in known.items()
        if len(rest) <= SYMBOL and rest in spec.description.split()
    ]
    links = [f"link.{field}" for field in (*specs(LinkParams), "preset")]
    near = f"; did you mean {min(symbols, key=_depth)}?" if symbols else ""
    near = near or hint(rest, [*known, *links])
    if number:
        near = near.replace("; did you mean ", f"; did you mean user{number}.")
    return f"there is no such parameter{near}"


def _depth(path: str) -> int:
    return path.count(".")


def resolved(name: str) -> tuple[int, list[str]]:
    """Return the user (0: all) and the complete names that a name means; ScenarioError, with the
    nearest name, where there is no such parameter.
    """
    number, rest = split_user(name)
    found = complete(rest)
    if not found or (number and found[0] not in user_specs()):
        raise ScenarioError(name, [unknown(name)])
    return number, found


def spec_of(name: str) -> Spec:
    """Return the declaration of a parameter; ScenarioError where there is no such parameter."""
    leaf = resolved(name)[1][0]
    return user_specs().get(leaf) or shared_specs()[leaf]


def value_of(scenario: Scenario, name: str) -> float | None:
    """Return a number of a scenario, that of the first user where several are meant; None where
    the parameter is no number or not given. ScenarioError where there is no such parameter or
    user.
    """
    number, (leaf, *_) = resolved(name)
    index = max(number - 1, 0)
    if index >= len(scenario.users):
        raise ScenarioError(scenario.name, [f"{name}: there is no user{index + 1}"])
    home = homes().get(leaf)
    if home is None:
        return None
    value = attrgetter(home.path)(scenario.users[index] if home.of_user else scenario)
    return None if value is None or isinstance(value, str) else float(value)


def doubts(scenario: Scenario) -> list[str]:
    """Return in words the values that are allowed but unusual, each once, with its first name."""
    found: dict[str, str] = {}
    for user in range(1, len(scenario.users) + 1):
        for name, spec in user_specs().items():
            if spec.usual is not None:
                text = spec.doubt(value_of(scenario, f"user{user}.{name}"))
                found.setdefault(text, f"user{user}.{name} = {text}")
    return [line for text, line in found.items() if text]


def varied(scenario: Scenario, name: str, value: object) -> Scenario:
    """Return the scenario with a parameter changed to a plain value, or, of a stackable name, to a
    column ``(runs, 1)``; ScenarioError where there is no such parameter, or it may not have that
    value.
    """
    number, complete_names = resolved(name)
    for leaf in complete_names:
        home = homes().get(leaf)
        if home is None:
            text = f"{leaf}: decides what a scenario is; make two scenarios"
            raise ScenarioError(scenario.name, [text])
        if number > len(scenario.users):
            raise ScenarioError(scenario.name, [f"{leaf}: there is no user{number}"])
        try:
            scenario = _changed(scenario, home, value, number)
        except ScenarioError:
            raise
        except ParameterError as error:
            group = leaf.rpartition(".")[0]
            raise ScenarioError(scenario.name, [f"{group}.{error}"]) from None
    return scenario


def _changed(scenario: Scenario, home: Home, value: object, number: int) -> Scenario:
    """Return the scenario with one parameter changed, for one user (0: all)."""
    if not home.of_user:
        return replaced(scenario, home.path, value)
    users = tuple(
        replaced(user, home.path, value) if number in (0, index) else user
        for index, user in enumerate(scenario.users, start=1)
    )
    return dataclasses.replace(scenario, users=users)
