# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Rivals of a comparison are tuned by search on their link: no worse than by their rules."""

import re

import pytest
from support.plain import load

from pmwvc_analysis.compare import settings as parameters
from pmwvc_analysis.compare.settings import (
    FAILED_COST,
    cost_of,
    parameters_of,
    path_error_m,
    tuned,
)
from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.controllers.record import loop_of
from pmwvc_core.simulation.session import simulate, simulate_one

CASES = [("virtual_coupling", 0.016), ("tdpa", 0.05)]
COUNT, FIRST_S = 5, 5  # fewer settings than a comparison searches, on shorter sessions


@pytest.fixture(autouse=True)
def quicker(monkeypatch):
    monkeypatch.setattr(parameters, "COUNT", COUNT)
    monkeypatch.setattr(parameters, "LONGEST_S", FIRST_S)


def by_rule(controller, loop):
    """Values that the published rules propose: the control of the search."""
    late, b = 0.5 * loop.round_trip_s, loop.damping
    if controller == "tdpa":
        damping = loop.contact_stiffness * late / 0.95 - b
        return {"damping": damping, "damping_max": 0.1 * loop.mass / loop.tick_s}
    stiffness = 0.8 * min(b / loop.tick_s, 1.5 * b / late)
    return {"stiffness": stiffness, "damping": 0.5 * b}


def session_with(controller, delay_s, values):
    """The session of the search with values given as settings."""
    texts = [f"baseline.{controller}.{name}={value}" for name, value in values.items()]
    return load(
        "carry_16ms",
        settings_texts=[f"controller={controller}", f"link.delay_s={delay_s}", *texts],
        duration_s=FIRST_S,
    )


@pytest.mark.parametrize(("controller", "delay_s"), CASES)
def test_a_rival_found_by_search_is_better_than_by_its_rule_and_as_printed(controller, delay_s):
    words = [f"controller={controller}", f"link.delay_s={delay_s}"]
    scenario = load("carry_16ms", settings_texts=words)
    shown = []
    found, tuning = tuned(scenario, shown.append)
    assert shown[-1] == 1.0
    assert {user.baseline for user in found.users} == {found.users[0].baseline}
    values = {name.rpartition(".")[2]: v for name, v in parameters_of(found).items()}
    rule = LIBRARY[controller].rule
    for name, (low, high) in rule.ranges.items():
        assert low <= values[name] <= high
        assert f"{name} {low:g} to {high:g}" in tuning
    printed, default = map(
        float,
        re.findall(
            rf"first {FIRST_S} s: the least cost, (\S+), of {COUNT} settings \((\S+) with", tuning
        )[0],
    )
    best = session_with(controller, delay_s, values)
    assert cost_of(simulate_one(best), best) == pytest.approx(printed, rel=1e-3)
    control = by_rule(controller, loop_of(scenario.users[0], scenario.server))
    sessions = [session_with(controller, delay_s, each) for each in ({}, control)]
    plain, ruled = simulate(sessions, keep=cost_of)
    assert plain == pytest.approx(default, rel=1e-3)
    assert printed < ruled
    if controller == "tdpa":  # which brakes every motion with its local damping
        assert values["damping"] < control["damping"]


def test_only_what_is_carried_has_a_path_and_a_session_that_never_coupled_fails():
    wall = load("wall", settings_texts=["controller=virtual_coupling"], duration_s=5.0)
    carried = load("carry_0ms", duration_s=5.0)
    assert path_error_m(simulate_one(wall), wall) == 0.0
    assert path_error_m(simulate_one(carried), carried) > 1e-4
    assert cost_of(simulate_one(wall), wall) < 10.0
    alone = load("carry_16ms", settings_texts=["link.loss=1"], duration_s=3.0)
    assert cost_of(simulate_one(alone), alone) == FAILED_COST


def test_where_every_setting_fails_the_defaults_are_kept():
    words = ["controller=pspm", "link.loss=1"]
    scenario = load("carry_16ms", settings_texts=words, duration_s=2.0)
    found, tuning = tuned(scenario, lambda ratio: None)
    assert found == scenario
    assert f"first 2 s: all {COUNT} settings fail, so the defaults are kept" in tuning
