# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A port that limits an unknown environment is reported with its amounts, and judged."""

import functools

import pytest
from support import plain as scenarios

from pmwvc_analysis.events import limits
from pmwvc_analysis.prediction.prediction import prediction
from pmwvc_analysis.prediction.text import lines
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.simulation.session import simulate_one


@functools.cache
def pressed(stiffness, damping, *settings):
    """A hand presses the slow wall for 8 s; decoded late, as App. C does."""
    texts = [
        "server.decoding=late",
        f"server.contact_stiffness={stiffness}",
        f"server.contact_damping={damping}",
        *settings,
    ]
    scenario = scenarios.load("wall_slow", settings_texts=texts)
    return simulate_one(scenario), scenario


def test_a_lost_wall_is_not_stable_and_the_amount_is_the_distance_of_device_and_avatar():
    traces, scenario = pressed(2000, 10)
    result = summary(traces, scenario)
    user = result["users"][0]
    assert abs(user["force_final_n"]) < 0.01
    assert result["stable"] is False
    assert result["instability"] == "environment lost"
    found = user["environment_limited"]
    assert found["position_m"] == pytest.approx(user["drift_m"], abs=0.5e-3)
    assert found["position_m"] > 0.03
    assert found["energy_j"] == pytest.approx(traces.server.accounts["withheld"][-1])
    words = limits.words(found)
    assert words == f"environment limited: {found['energy_j'] * 1e3:.3g} mJ, 35.7 mm"


def test_a_limited_wall_that_holds_is_stable_and_states_the_amount():
    traces, scenario = pressed(2000, 0)
    user = summary(traces, scenario)["users"][0]
    assert verdict(traces, scenario).stable
    assert user["force_final_n"] > 0.9
    assert 0.2e-3 < user["environment_limited"]["position_m"] < 1e-3


def test_a_wall_within_the_rule_is_not_limited():
    traces, scenario = pressed(500, 0)
    assert summary(traces, scenario)["users"][0]["environment_limited"] is None
    assert limits.withheld(traces, scenario) == {}
    assert prediction(scenario, live=False)["environment_limited"] is False


def test_the_limit_is_predicted_and_neither_stability_nor_stiffness_is_promised():
    traces, scenario = pressed(2000, 10)
    values = prediction(scenario, live=False)
    assert values["environment_limited"] is True
    assert values["stable"] is values["k_felt"] is values["mass_felt"] is None
    said = "\n".join(lines(scenario, live=False))
    assert "K T + 2B = 60 N s/m, above 25 N s/m: the server port will limit" in said
    assert "Every part is passive" not in said
    assert "1450" not in said
    text = " ".join(each["text"] for each in summary(traces, scenario)["outcomes"])
    assert text == "No stability was predicted; the session was not stable."


def test_two_users_share_what_was_withheld():
    settings = ("users=2", "user2.server.contact_stiffness=500", "user2.server.contact_damping=0")
    traces, scenario = pressed(2000, 10, *settings)
    found = limits.withheld(traces, scenario)
    total = sum(entry.energy_j for entry in found.values())
    assert total == pytest.approx(traces.server.accounts["withheld"][-1], rel=1e-6)


def test_without_the_scenario_nothing_is_claimed():
    traces, _ = pressed(2000, 10)
    assert summary(traces, None)["users"][0]["environment_limited"] is None


@pytest.mark.parametrize(
    ("stiffness", "gap_m", "channel"),
    [
        (200, 0.005, "strict"),
        (12000, 0.0041, "plain"),
        (50000, 0.005, "strict"),
    ],
)
def test_a_learned_wall_leaves_the_device_where_the_link_alone_does(channel, stiffness, gap_m):
    """What the impacts withheld until the slope was learned is repaid."""
    texts = [f"server.contact_stiffness={stiffness}", f"server.gap_m={gap_m}"]
    scenario = scenarios.load("wall_slow", settings_texts=[*texts, f"channel={channel}"])
    traces = simulate_one(scenario)
    found = summary(traces, scenario)
    (offset,) = [each for each in found["outcomes"] if each["what"] == "offset"]
    assert offset["hit"] is True, offset["text"]
    assert offset["measured"] == pytest.approx(offset["predicted"], abs=0.3e-3)
    said = [event["what"] for event in found["events"] if event["who"] == "user1"]
    learned = [text for text in said if "learned K T + 2B" in text]
    assert len(learned) == (stiffness * 0.02 > 25.0)
