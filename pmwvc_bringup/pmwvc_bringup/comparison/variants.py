# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Variants of a scenario by name: ``--controllers waves,ledger,filter_bank+position,tdpa``.

``pmwvc`` is the scenario's own settings with waves; ``waves`` is the plain channel without port
filters; a feature stands for that with it, and several may be joined by ``+``; the other
controllers stand for themselves. Where a scenario leaves them open, the gain of position feedback
is a default, and the order of the velocity filter is the one with the least noise for its
anti-aliasing filter. ``velocity_filter_printed`` is of order 1, as App. D has it.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence

from pmwvc_bringup import scenarios as files
from pmwvc_core.controllers import library as controllers
from pmwvc_core.ends.assembly import server_end_of, user_end_of
from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.params import MasterParams, VelocityFilterParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave.design.velocity_filter_design import chosen, noise_gain

PLAIN: Mapping[str, str] = {
    "controller": "pmwvc",
    "channel": "plain",
    "server.compensation": "none",
    "server.decoding": "late",
    "master.velocity_filter.kind": "none",
    "master.bank.kind": "none",
    "master.position.feedback": "none",
}
FEATURES: Mapping[str, Mapping[str, str]] = {
    "waves": {},
    "printed": {"server.coupling": "unknown", "server.compensation": "printed"},
    "corrected": {"server.coupling": "unknown", "server.compensation": "corrected"},
    "ledger": {"server.coupling": "unknown", "server.compensation": "ledger"},
    "secant": {
        "server.coupling": "unknown",
        "server.compensation": "ledger",
        "server.decoding": "secant",
    },
    "velocity_filter": {"master.velocity_filter.kind": "exact"},
    "velocity_filter_printed": {
        "master.velocity_filter.kind": "equivalent",
        "master.velocity_filter.order": "1",
        "master.velocity_filter.share": "0.5",
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
    return [*controllers.names(), *FEATURES]


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


def _build(scenario: Scenario) -> None:
    """Make both ends of a scenario's controller; refused where parameters do not allow it."""
    for number in range(len(scenario.users)):
        user_end_of(scenario, number)
    server_end_of(scenario)


def settings_of(variant: str, defaults: Mapping[str, str]) -> list[str]:
    """Return the settings ``name=value`` of a variant: a name, or features joined by ``+``.

    ``defaults`` are those of :func:`defaults_of`; ScenarioError names the known variants.
    """
    if variant in controllers.names():
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
    kept, left_out = [], {}
    for variant in variants:
        texts = [*settings_texts, *settings_of(variant, defaults)]
        try:
            _build(files.load(name, settings_texts=texts))
        except ScenarioError as error:
            left_out[variant] = "; ".join(error.problems)
        except ParameterError as error:
            left_out[variant] = str(error)
        else:
            kept.append(variant)
    return (kept, left_out) if kept else (list(variants), {})


def variants_of(text: str | None) -> Sequence[str]:
    """Return the variants of a comma-separated list; ScenarioError where one is given twice."""
    if text is None:
        return ()
    variants = [name.strip() for name in text.split(",")]
    if not all(variants) or len(set(variants)) < len(variants):
        raise ScenarioError("--controllers", [f"{text}: must be different names, a,b,..."])
    return variants
