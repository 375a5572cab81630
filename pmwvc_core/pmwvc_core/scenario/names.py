# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The dotted names of a scenario's parameters: ``server.contact_stiffness`` means every user,
``user2.device.mass`` that one, ``link.delay_s`` and ``link.*.delay_s`` both directions. Names
within one dataclass: :mod:`pmwvc_core.params.names`.
"""

import dataclasses
import re
from operator import attrgetter

from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.params import LinkParams, Spec, specs
from pmwvc_core.params.names import hint, replaced
from pmwvc_core.scenario.scenario import PARAMETERS, Scenario

SYMBOL = 2  # letters of a symbol of the equations, at most
USER_NAME = re.compile(r"user([1-9][0-9]*)\.(.+)")


def split_user(name: str) -> tuple[int, str]:
    """Return the number of the user that a name begins with (0: none), and the rest."""
    match = USER_NAME.fullmatch(name)
    return (int(match[1]), match[2]) if match else (0, name)


def complete(name: str) -> list[str]:
    """Return the complete names that a name without user means; none for an unknown one."""
    short = name.removeprefix("link.").removeprefix("*.")
    if name.startswith("link.") and short in specs(LinkParams):
        return [f"link.up.{short}", f"link.down.{short}"]
    return [name] if name in PARAMETERS else []


def unknown(name: str) -> str:
    """Return the refusal of an unknown name, with the nearest, or one of that symbol."""
    number, rest = split_user(name)
    of_user = [path for path, each in PARAMETERS.items() if each.of_user]
    known = of_user if number else sorted(PARAMETERS, key=lambda path: path not in of_user)
    short = len(rest) <= SYMBOL
    symbols = [p for p in known if short and rest in PARAMETERS[p].spec.description.split()]
    if symbols:
        near = f"; did you mean {min(symbols, key=lambda path: path.count('.'))}?"
    else:
        near = hint(rest, [*known, *(f"link.{field}" for field in (*specs(LinkParams), "preset"))])
    if number:
        near = near.replace("; did you mean ", f"; did you mean user{number}.")
    return f"there is no such parameter{near}"


def resolved(name: str) -> tuple[int, list[str]]:
    """Return the user (0: all) and the complete names that a name means; else ScenarioError."""
    number, rest = split_user(name)
    found = complete(rest)
    if not found or (number and not PARAMETERS[found[0]].of_user):
        raise ScenarioError(name, [unknown(name)])
    return number, found


def spec_of(name: str) -> Spec:
    """Return the declaration of a parameter; ScenarioError where there is no such parameter."""
    return PARAMETERS[resolved(name)[1][0]].spec


def value_of(scenario: Scenario, name: str) -> float | None:
    """Return a number, that of the first user, or None; ScenarioError for unknown names."""
    number, (leaf, *_) = resolved(name)
    index = max(number - 1, 0)
    if index >= len(scenario.users):
        raise ScenarioError(scenario.name, [f"{name}: there is no user{index + 1}"])
    _, path, of_user = PARAMETERS[leaf]
    value = attrgetter(path)(scenario.users[index] if of_user else scenario)
    return None if "." not in path or value is None or isinstance(value, str) else float(value)


def doubts(scenario: Scenario) -> list[str]:
    """Return in words the values that are allowed but unusual, each once, with its first name."""
    found: dict[float, str] = {}
    for user in scenario.users:
        for name, (spec, path, of_user) in PARAMETERS.items():
            if not of_user or spec.usual is None:
                continue
            value = attrgetter(path)(user)
            text = f"{value:g} s: longer than on any network on Earth; {value:g} ms is"
            if value > spec.usual:
                found.setdefault(value, f"{user.name}.{name} = {text} {value / 1e3:g}")
    return list(found.values())


def varied(scenario: Scenario, name: str, value: object) -> Scenario:
    """Return the scenario with a value, or a column ``(runs, 1)``; else ScenarioError."""
    number, leaves = resolved(name)
    for leaf in leaves:
        _, path, of_user = PARAMETERS[leaf]
        if "." not in path:
            text = f"{leaf}: decides what a scenario is; make two scenarios"
            raise ScenarioError(scenario.name, [text])
        if number > len(scenario.users):
            raise ScenarioError(scenario.name, [f"{leaf}: there is no user{number}"])
        try:
            if of_user:
                users = tuple(
                    replaced(user, path, value) if number in (0, index) else user
                    for index, user in enumerate(scenario.users, start=1)
                )
                scenario = dataclasses.replace(scenario, users=users)
            else:
                scenario = replaced(scenario, path, value)
        except ScenarioError:
            raise
        except ParameterError as error:
            group = leaf.rpartition(".")[0]
            raise ScenarioError(scenario.name, [f"{group}.{error}"]) from None
    return scenario
