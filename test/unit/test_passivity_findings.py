# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One criterion of passivity, with amount and tolerance, for all that print a verdict."""

import dataclasses
import json
import re

import numpy as np
import pytest
from support import handmade

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.criterion import Balance, together
from pmwvc_analysis.report.report import render
from pmwvc_analysis.traces.holes import Unjudged
from pmwvc_analysis.traces.thresholds import TOLERANCE_J
from pmwvc_analysis.verdicts.passivity import amount, passivity, verdict
from pmwvc_analysis.verdicts.verdicts import summary

TIME_S = np.array([0.0, 1.0, 2.0])
HOLE = Unjudged(0.5, 1.5, "user1")


def one(least_j, **settings):
    balance = np.array([0.0, least_j, 1e-3])
    unjudged = settings.pop("unjudged", ())
    found = Balance(TIME_S, balance, 0.0 * TIME_S, moved_j=0.0, **settings).judged(
        "user1", "up", unjudged
    )
    return dataclasses.replace(found, moved_j=0.1)


@pytest.mark.parametrize(("share", "passive"), [(0.99, True), (1.01, False)])
def test_the_tolerance_has_two_sides(share, passive):
    assert one(-share * TOLERANCE_J).passive is passive


@pytest.mark.parametrize(("share", "passive"), [(0.99, True), (1.01, False)])
def test_a_declared_storage_may_be_given_out_and_no_more(share, passive):
    found = one(-share * 5e-3, declared_j=5e-3 - TOLERANCE_J)
    assert found.passive is passive
    assert found.least_j == pytest.approx(-share * 5e-3)


def test_a_hole_makes_no_violation_and_no_proof():
    assert one(1e-3, unjudged=(HOLE,)).passive is None
    assert one(-1e-3, unjudged=(HOLE,)).passive is False  # seen is seen
    assert "from 0.50 to 1.50 s user1 was not recorded" in one(1e-3, unjudged=(HOLE,)).why


def test_a_balance_that_is_no_number_is_not_passive():
    assert one(float("nan")).passive is False


def test_nothing_seen_is_not_judged():
    empty = np.zeros(0)
    assert Balance(empty, empty, empty).judged("a", "up").passive is None


def test_what_moved_no_energy_is_no_proof():
    """With every packet lost all ports were "passive", as was predicted."""
    none = 0.0 * TIME_S
    found = Balance(TIME_S, none, none).judged("user1", "up")
    assert found.passive is None and found.why == "no energy was moved"
    assert Balance(TIME_S, none + 1e-12, none).judged("user1", "up").passive is True


def test_one_violation_decides_and_silence_is_no_proof():
    good, bad, unknown = one(0.0), one(-1.0), one(0.0, unjudged=(HOLE,))
    assert together([good.passive, unknown.passive, bad.passive]) is False
    assert together([good.passive, unknown.passive]) is None
    assert together([good.passive]) is True
    assert together([]) is None


@pytest.mark.parametrize("gain", [1.0, 1.01, 1.2])
def test_summary_budget_and_report_agree_and_name_amount_and_tolerance(gain):
    traces, scenario = handmade.session(gain=gain), handmade.scenario()
    energies = budget(traces, scenario)
    found = passivity(traces, scenario, energies)
    result = summary(traces, scenario, energies)
    page = render(traces, scenario, result, [], energies)
    passive = gain == 1.0
    assert all(user["passive"] is passive for user in result["users"])
    assert result["check"]["passed"] is all(line["ok"] for line in result["verdict"]) is passive
    assert result["passivity"]["passive"] is passive
    assert bool(result["active"]) is not passive
    assert all(sentence in page for sentence in result["active"])
    assert ("NOT passive" in page) is not passive
    for owner in ("user1", "user2"):
        said = verdict(found, owner)
        assert said in page
        assert re.search(r"least balance .*\d .?J.*tolerance [\d.]+ .J", said)
    json.dumps(result, allow_nan=False)


@pytest.mark.parametrize(("moved_j", "said"), [
    (0.663, "less than 0.01 % of 663 mJ moved"),
    (0.159, "0.02 % of 159 mJ moved"),
])  # fmt: skip
def test_a_small_ratio_is_not_printed_as_zero(moved_j, said):
    assert said in amount(dataclasses.replace(one(-29.6e-6), moved_j=moved_j))


def test_a_server_that_gives_out_more_than_it_took_in_is_not_passive():
    traces, scenario = handmade.session(), handmade.scenario()
    passive = passivity(traces, scenario, None)
    assert passive.passive("server") is True
    for place in range(2):
        traces.server.energy_v_s[place] = 1.1 * traces.server.energy_u_s[place]
    found = passivity(traces, scenario, None)
    assert found.passive("server") is False
    assert found.session is False


def test_a_driven_environment_may_give_out_energy_of_its_own():
    traces = handmade.session()
    for place in range(2):
        traces.server.energy_v_s[place] = 1.1 * traces.server.energy_u_s[place]
    scenario = handmade.scenario(
        server__environment="active_wall",
        server__coupling="unknown",
        server__active_wall__amplitude_m=0.01,
        users=1,
    )
    found = passivity(traces, scenario, None)
    assert found.passive("server") is None
    assert "driven" in verdict(found, "server")


def test_without_the_server_nothing_is_judged():
    traces = handmade.session()
    traces.server = None
    found = passivity(traces, handmade.scenario(), None)
    assert found.session is None
    assert "server's trace is missing" in verdict(found, "user1")


@pytest.mark.parametrize(("held_j", "said"), [(0.0, False), (4e-4, True)])
def test_what_held_forces_explain_is_said_with_the_amount(held_j, said):
    found = dataclasses.replace(one(-1e-3), held_j=held_j, why="its loop stood still")
    assert amount(found).endswith("; its loop stood still") is said


def test_without_the_scenario_what_a_port_gave_out_may_have_been_stored():
    """Its declared storage is not known then; the amount is named."""
    traces = handmade.session()
    traces.server.energy_u_s[0] += 5e-3 * (traces.server.time_s > 2.0)
    known, unknown = (passivity(traces, each, None) for each in (handmade.scenario(), None))
    assert (known.passive("user1"), unknown.passive("user1")) == (False, None)
    assert "it gave out" in verdict(unknown, "user1")
    assert "its declared storage is not known" in verdict(unknown, "user1")
