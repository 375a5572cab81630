# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every combination of the values of several parameters, as scenarios; one of them may be the
variant by name: ``--controllers waves,ledger,filter_bank+position,tdpa``.

``pmwvc`` is the scenario's own settings with waves; ``waves`` is the plain channel without port
filters; a feature stands for that with it, and several may be joined by ``+``; the other
controllers stand for themselves. Where a scenario leaves them open, the gain of position feedback
is a default, and the order of the velocity filter is the one with the least noise for its
anti-aliasing filter. ``velocity_filter_printed`` is of order 1, as App. D has it.
"""

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import yaml

from pmwvc_bringup import scenarios as files
from pmwvc_core.controllers import library
from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.made.user import made_user
from pmwvc_core.params import MasterParams, VelocityFilterParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave.velocity_filter_design import chosen, noise_gain

CONTROLLER = "controller"
MOST = 100  # sessions, whose traces are held in memory
PLAIN: Mapping[str, str] = {
    "controller": "pmwvc",
    "channel": "plain",
    "server.compensation": "none",
    "server.decoding": "late",
    "master.velocity_filter.kind": "none",
    "master.bank.kind": "none",
    "master.position.feedback": "none",
}
LEDGER = {"server.coupling": "unknown", "server.compensation": "ledger"}
FEATURES: Mapping[str, Mapping[str, str]] = {
    "waves": {},
    "printed": {"server.coupling": "unknown", "server.compensation": "printed"},
    "corrected": {"server.coupling": "unknown", "server.compensation": "corrected"},
    "ledger": LEDGER,
    "secant": {**LEDGER, "server.decoding": "secant"},
    "velocity_filter": {"master.velocity_filter.kind": "exact"},
    "velocity_filter_printed": {
        f"master.velocity_filter.{name}": value
        for name, value in (("kind", "equivalent"), ("order", "1"), ("share", "0.5"))
    },
    "filter_bank": {"master.bank.kind": "dissertation"},
    "complementary_bank": {"master.bank.kind": "complementary"},
    "position": {"master.position.feedback": "budgeted"},
    "position_printed": {"master.position.feedback": "printed"},
    "position_integral": {"master.position.feedback": "integral"},
}
DEFAULT_GAIN = "20"  # [sqrt(W)/m], App. E section 4, where the scenario has none
ORDERS = range(2, 9)  # of a velocity filter


def names() -> list[str]:
    """Return the name of every controller and feature."""
    return [*library.names(), *FEATURES]


def defaults_of(scenario: Scenario) -> dict[str, str]:
    """Return the settings that features need beside their kind and the scenario leaves open."""
    found = {}
    if not any(float(user.master.position.gain) > 0.0 for user in scenario.users):
        found["master.position.gain"] = DEFAULT_GAIN
    masters = [user.master for user in scenario.users]
    if all(master.velocity_filter == VelocityFilterParams() for master in masters):
        left = {order: max(_noise_left(master, order) for master in masters) for order in ORDERS}
        found["master.velocity_filter.order"] = str(min(left, key=lambda order: left[order]))
    return found


def _noise_left(master: MasterParams, order: int) -> float:
    """Return the noise gain of the designed velocity filter of an order; inf where none exists."""
    own = VelocityFilterParams(kind="exact", order=order)
    try:
        designed = chosen(dataclasses.replace(master, velocity_filter=own))
    except ParameterError:
        return math.inf
    return round(noise_gain(designed), 2)


def settings_of(variant: str, defaults: Mapping[str, str]) -> list[str]:
    """Return the settings ``name=value`` of a variant: a name, or features joined by ``+``.
    ``defaults`` are those of :func:`defaults_of`; ScenarioError names the known variants.
    """
    if variant in library.names():
        return [f"controller={variant}"]
    found = dict(PLAIN)
    for part in variant.split("+"):
        if part not in FEATURES:
            known = f"must be one of {', '.join(names())}; features may be joined by +"
            raise ScenarioError("--controllers", [f"{part!r}: {known}"])
        groups = {name.rpartition(".")[0] for name in FEATURES[part]}
        found |= {k: v for k, v in defaults.items() if k.rpartition(".")[0] in groups}
        found |= FEATURES[part]
    return [f"{name}={value}" for name, value in found.items()]


def fitting(
    name: str, variants: Sequence[str], settings_texts: Sequence[str]
) -> tuple[list[str], dict[str, str]]:
    """Return the variants that a scenario can be run with, and the reasons against the others.
    Where it cannot be run with any, all are returned: then the scenario itself is wrong.
    """
    defaults = defaults_of(files.load(name, settings_texts=settings_texts)) if variants else {}
    left_out = {}
    for variant in variants:
        texts = [*settings_texts, *settings_of(variant, defaults)]
        try:
            scenario = files.load(name, settings_texts=texts)
            for user in scenario.users:
                made_user(user, scenario)
            ServerEnd(scenario)
        except ScenarioError as error:
            left_out[variant] = "; ".join(error.problems)
        except ParameterError as error:
            left_out[variant] = str(error)
    if len(left_out) == len(variants):
        return list(variants), {}
    return [variant for variant in variants if variant not in left_out], left_out


def variants_of(text: str | None) -> Sequence[str]:
    """Return the variants of a comma-separated list; ScenarioError where one is given twice."""
    if text is None:
        return ()
    variants = [name.strip() for name in text.split(",")]
    if not all(variants) or len(set(variants)) < len(variants):
        raise ScenarioError("--controllers", [f"{text}: must be different names, a,b,..."])
    return variants


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
    name: str, over: Sequence[str], *, controllers: Sequence[str] = (),
    settings_texts: Sequence[str] = (), users: int | None = None, duration_s: float | None = None,
) -> list[Combination]:  # fmt: skip
    """Return every combination of the values of ``name=a,b,c`` texts, the last varying fastest.

    ``controllers`` are names of variants, an axis of their own; the others are settings of all, as
    with ``pmwvc simulate``. ScenarioError with every mistake of the scenario, the values and their
    combinations, each once.
    """
    axes, problems = _axes(over)
    defaults: dict[str, str] = {}
    if controllers:
        if CONTROLLER in axes:
            problems.append("--controllers and --over controller: give one of them")
        axes |= {CONTROLLER: list(controllers)}
        defaults = defaults_of(files.load(name, settings_texts=settings_texts))
    if (count := math.prod(map(len, axes.values()))) > MOST:
        raise ScenarioError(name, [*problems, f"{count} combinations: must be at most {MOST}"])
    last = [path.rpartition(".")[2] for path in axes]
    short = [b if last.count(b) == 1 else path for b, path in zip(last, axes, strict=True)]
    found = []
    for values in itertools.product(*axes.values()):
        texts = [f"{path}={value}" for path, value in zip(axes, values, strict=True)]
        if controllers:
            texts = [*settings_of(values[-1], defaults), *texts[:-1]]
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
