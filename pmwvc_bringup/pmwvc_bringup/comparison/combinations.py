# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every combination of the values of several parameters, as scenarios."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import yaml

from pmwvc_bringup import scenarios as files
from pmwvc_bringup.comparison.variants import defaults_of, settings_of
from pmwvc_core.controllers.library import record_of
from pmwvc_core.errors import ScenarioError
from pmwvc_core.scenario.scenario import Scenario

CONTROLLER = "controller"
MOST = 100  # sessions, whose traces are held in memory


@dataclass(frozen=True)
class Combination:
    """One choice of values: its label, the settings, the scenario, and whether a setting gives a
    parameter of its baseline; once tuned, where those parameters are from.
    """

    label: str
    settings: dict[str, object]
    scenario: Scenario
    given: bool = False
    tuning: str | None = None


def combinations(
    name: str,
    over: Sequence[str],
    *,
    controllers: Sequence[str] = (),
    settings_texts: Sequence[str] = (),
    users: int | None = None,
    duration_s: float | None = None,
) -> list[Combination]:
    """Return every combination of the values of ``name=a,b,c`` texts, the last varying fastest.

    ``controllers`` are words of :mod:`pmwvc_bringup.comparison.variants`, an axis of their own;
    the others are settings of all, as with ``pmwvc simulate``. ScenarioError with every mistake of
    the scenario, the values and their combinations, each once.
    """
    axes, problems = _axes(over)
    if controllers:
        if CONTROLLER in axes:
            problems.append("--controllers and --over controller: give one of them")
        axes |= {CONTROLLER: list(controllers)}
    defaults = defaults_of(files.load(name, settings_texts=settings_texts)) if controllers else {}
    count = 1
    for each in axes.values():
        count *= len(each)
    if count > MOST:
        problems.append(f"{count} combinations: must be at most {MOST}")
    names = _short(list(axes))
    found = []
    for chosen in itertools.product(*axes.values()) if count <= MOST else ():
        texts = [f"{path}={value}" for path, value in zip(axes, chosen, strict=True)]
        if controllers:
            texts = [*settings_of(chosen[-1], defaults), *texts[:-1]]
        try:
            scenario = files.load(
                name, settings_texts=[*settings_texts, *texts], users=users, duration_s=duration_s
            )
        except ScenarioError as error:
            problems += [problem for problem in error.problems if problem not in problems]
            continue
        given = _given([*settings_texts, *texts], scenario.controller)
        label = ", ".join(f"{n} = {v}" for n, v in zip(names, chosen, strict=True))
        values = dict(zip(axes, map(yaml.safe_load, chosen), strict=True))
        found.append(Combination(label or scenario.name, values, scenario, given))
    if problems:
        raise ScenarioError(name, problems)
    return found


def _given(texts: Sequence[str], controller: str) -> bool:
    """Tell whether a setting names a parameter of a baseline."""
    rule = record_of(controller).rule
    group = rule.group if rule else controller
    return any(f"baseline.{group}." in text.partition("=")[0] for text in texts)


def _axes(over: Sequence[str]) -> tuple[dict[str, list[str]], list[str]]:
    """Return the texts of the values by parameter, and the problems."""
    axes: dict[str, list[str]] = {}
    problems = []
    for text in over:
        path, equals, rest = text.partition("=")
        path = path.strip()
        values = [value.strip() for value in rest.split(",")]
        if not equals or not path or not all(values):
            problems.append(f"--over {text}: must be name=a,b,..., e.g. link.delay_s=0,0.016")
        elif path in axes:
            problems.append(f"--over {path}: is given twice; give all its values once")
        elif len(set(values)) < len(values):
            problems.append(f"--over {text}: a value is given twice")
        else:
            axes[path] = values
    return axes, problems


def _short(paths: list[str]) -> list[str]:
    """Return the last part of each name where it is unique, else the whole name."""
    last = [path.rpartition(".")[2] for path in paths]
    return [
        leaf if last.count(leaf) == 1 else path for leaf, path in zip(last, paths, strict=True)
    ]
