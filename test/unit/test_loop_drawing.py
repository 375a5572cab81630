# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of the loop carries the session's own numbers."""

import dataclasses
import xml.etree.ElementTree as ET

import pytest
from support import handmade

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.report.loop import blocks, drawing
from pmwvc_bringup.scenarios import load
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.words import count, listed

OWN = ("device", "port", "filter", "hold", "up", "down")


def texts(svg):
    return [element.text for element in ET.fromstring(svg).iter("text")]


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"controller": "direct"},
        {"controller": "tdpa"},
        {"master__bank__kind": "complementary"},
        {"server__environment": "wall", "users": 1},
    ],
)
def test_the_energies_of_all_blocks_are_those_of_the_budget(settings):
    scenario = handmade.scenario(duration_s=2.0, **settings)
    traces = simulate_one(scenario)
    found = budget(traces, scenario)
    shared, hands, own = 0.0, 0.0, 0.0
    for user in scenario.users:
        of = blocks(scenario, user, found)
        hands += of["hand"].energy_j
        own += sum(
            of[k].energy_j or 0.0 for k in ("device", "port", "filter", "hold", "up", "down")
        )
        shared = sum(of[k].energy_j for k in ("decoder", "contact", "object"))
    assert hands == pytest.approx(own + shared + found.residual_j[-1], abs=1e-12)
    assert abs(hands) > 1e-4


def test_the_drawing_has_every_block_and_its_numbers():
    scenario = handmade.scenario(duration_s=1.0, link__delay_s=0.024, device__mass=0.31)
    found = blocks(scenario, scenario.users[0], budget(simulate_one(scenario), scenario))
    drawn = drawing(found, name="user1", waves=True)
    places = [element.get("x") for element in ET.fromstring(drawn).iter("rect")]
    assert len(places) == len(found) == 10
    shown = texts(drawn)
    for text in ("0.31 kg", "24 ms", "b = 25 N s/m", "1 kHz", "125 Hz", "K = 500 N/m", "u_m"):
        assert text in shown
    assert "u_m" not in texts(drawing(found, name="user1", waves=False))


def test_what_generated_energy_is_marked():
    scenario = handmade.scenario(duration_s=1.0)
    found = blocks(scenario, scenario.users[0], None)
    found["decoder"] = with_energy(found["decoder"], -2e-3)
    root = ET.fromstring(drawing(found, name="user1", waves=True))
    marked = [
        element.text for element in root.iter("text") if element.get("class") == "loop-alarm"
    ]
    assert marked == ["E = −2 mJ"]


def with_energy(block, energy):
    """The block with another energy."""
    return block._replace(energy_j=energy)


def test_names_cannot_become_markup():
    scenario = handmade.scenario(duration_s=1.0)
    (user, *_) = scenario.users
    user = dataclasses.replace(user, name="<b>&")
    markup = drawing(blocks(scenario, user, None), name=user.name, waves=True)
    assert ET.fromstring(markup).get("aria-label") == "Control loop of <b>&"


def test_counts_and_lists_read_well():
    assert [count(n, "user") for n in (0, 1, 2)] == ["0 users", "1 user", "2 users"]
    assert [listed(list("abc")[:n]) for n in range(4)] == ["", "a", "a and b", "a, b and c"]


def test_on_the_strict_channel_no_filter_and_no_hold_is_drawn():
    texts = ["channel=strict", "master.deadband.kind=weber"]
    scenario = load("carry_16ms", settings_texts=texts)
    found = blocks(scenario, scenario.users[0], None)
    assert (found["filter"].title, found["hold"].title) == ("sender", "playout")
    assert "deadband 10%" in found["filter"].lines
    plain = load("carry_16ms", settings_texts=["channel=plain"])
    assert blocks(plain, plain.users[0], None)["hold"].title == "hold"
