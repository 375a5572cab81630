# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every combination of the values of several parameters, as scenarios."""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import yaml

from pmwvc_bringup import scenarios as files
from pmwvc_core.errors import ScenarioError
from pmwvc_core.scenario.scenario import Scenario

MOST = 100  # sessions, whose traces are held in memory


class Combination(NamedTuple):
    """One choice of values: its label, the settings, the scenario, and whether a setting gives a
    parameter of its baseline; once tuned, where those parameters are from.
    """

    label: str
    settings: dict[str, object]
    scenario: Scenario
    given: bool = False
    tuning: str | None = None


def combinations(
    name: str, over: Sequence[str], *, settings_texts: Sequence[str] = (),
    users: int | None = None, duration_s: float | None = None,
) -> list[Combination]:  # fmt: skip
    """Return every combination of the values of ``name=a,b,c`` texts, the last varying fastest;
    the others are settings of all, as with ``pmwvc simulate``. ScenarioError with every mistake of
    the scenario, the values and their combinations, each once.
    """
    axes, problems = _axes(over)
    if (count := math.prod(map(len, axes.values()))) > MOST:
        raise ScenarioError(name, [*problems, f"{count} combinations: must be at most {MOST}"])
    last = [path.rpartition(".")[2] for path in axes]
    short = [b if last.count(b) == 1 else path for b, path in zip(last, axes, strict=True)]
    found = []
    for values in itertools.product(*axes.values()):
        texts = [f"{path}={value}" for path, value in zip(axes, values, strict=True)]
        texts = [*settings_texts, *texts]
        try:
            scenario = files.load(name, settings_texts=texts, users=users, duration_s=duration_s)
        except ScenarioError as error:
            problems += [problem for problem in error.problems if problem not in problems]
            continue
        baseline = f"baseline.{scenario.controller}."
        given = any(baseline in text.partition("=")[0] for text in texts)
        label = ", ".join(f"{n} = {v}" for n, v in zip(short, values, strict=True))
        settings = dict(zip(axes, map(yaml.safe_load, values), strict=True))
        found.append(Combination(label or scenario.name, settings, scenario, given))
    if problems:
        raise ScenarioError(name, problems)
    return found


def _axes(over: Sequence[str]) -> tuple[dict[str, list[str]], list[str]]:
    """Return the texts of the values by parameter, and the problems."""
    axes: dict[str, list[str]] = {}
    problems = []
    for text in over:
        path, _, rest = text.partition("=")
        path, values = path.strip(), [value.strip() for value in rest.split(",")]
        if not path or not all(values):
            problems.append(f"--over {text}: must be name=a,b,..., e.g. link.delay_s=0,0.016")
        elif path in axes:
            problems.append(f"--over {path}: is given twice; give all its values once")
        elif len(set(values)) < len(values):
            problems.append(f"--over {text}: a value is given twice")
        else:
            axes[path] = values
    return axes, problems
