# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions with position feedback and port filters as pure functions are those of the classes."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from support import golden

from pmwvc_core.compiled import compiled
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.bulk.run import can_run, run, session
from pmwvc_core.simulation.bulk.traces import traces_of
from pmwvc_core.simulation.session import simulate_one

CONFIG = Path(__file__).resolve().parents[3] / "pmwvc_bringup" / "config"
FILTERS = {
    "equivalent": {"velocity_filter": {"kind": "equivalent", "order": 1, "alpha": 0.9}},
    "exact": {"velocity_filter": {"kind": "exact", "order": 2, "cutoff_hz": 40.0}},
    "complementary": {"velocity_filter": {"kind": "complementary", "order": 1, "cutoff_hz": 30.0}},
    "bank": {
        "bank": {"kind": "complementary"},
        "local_model": {"acts": "above", "begins_m": -0.03, "stiffness": 300.0},
        "velocity_filter": {"kind": "equivalent", "order": 1, "alpha": 0.9},
    },
    "published bank": {"bank": {"kind": "dissertation"}},
}
POSITIONS = {
    "printed": {"feedback": "printed", "gain": 30.0},
    "budgeted": {"feedback": "budgeted", "gain": 30.0, "storage_j": 0.01},
    "adapts": {"feedback": "budgeted", "adapts": True, "storage_j": 0.02},
    "integral": {"feedback": "integral", "gain": 20.0, "storage_j": 0.003},
    "poor": {"feedback": "budgeted", "gain": 100.0, "most_j": 0.002},
}


def scenario_of(name, channel, position, dof=1, seconds=1.5):
    return scenario_with(name, channel, {"position": POSITIONS[position]}, dof, seconds)


def scenario_with(name, channel, settings, dof=1, seconds=1.5):
    mapping = yaml.safe_load((CONFIG / f"{name}.yaml").read_text("utf-8"))
    master = mapping.get("master", {}) | settings
    given = {"channel": channel, "dof": dof, "duration_s": seconds, "master": master}
    return parse_scenario(mapping | given)


@pytest.mark.parametrize(
    ("name", "dof"), [("wifi_bursty", 1), ("wifi_bursty", 3), ("wall", 1), ("reorder_storm", 1)]
)
@pytest.mark.parametrize("channel", ["plain", "strict"])
@pytest.mark.parametrize("position", POSITIONS)
def test_a_session_is_that_of_the_classes(position, channel, name, dof):
    if position == "printed" and channel == "strict":
        pytest.skip("refused: it can make energy")
    compare(scenario_of(name, channel, position, dof))


@pytest.mark.parametrize(("name", "dof"), [("wifi_bursty", 1), ("wall", 3)])
@pytest.mark.parametrize("channel", ["plain", "strict"])
@pytest.mark.parametrize("filters", FILTERS)
def test_a_session_with_filters_is_that_of_the_classes(filters, channel, name, dof):
    compare(scenario_with(name, channel, FILTERS[filters], dof))


MATRIX = "30 6 0; 6 20 4; 0 4 25"
SERVERS = {
    "grip": {"contact": "grip"},
    "two-sided": {"contact": "bilateral"},
    "unwrapped grip": {"contact": "grip", "coupling": "unwrapped"},
    "unwrapped": {"contact": "bilateral", "coupling": "unwrapped", "integrator": "trapezoid"},
    "one step": {"contact": "bilateral", "coupling": "one_step_delay"},
}


@pytest.mark.parametrize("channel", ["plain", "strict"])
@pytest.mark.parametrize("server", SERVERS)
def test_a_session_with_coupled_axes_is_that_of_the_classes(server, channel):
    compare(coupled(server, channel))


def coupled(server, channel):
    """Return a session whose first user has a matrix, and loses packets for a while."""
    mapping = yaml.safe_load((CONFIG / "carry_16ms.yaml").read_text("utf-8"))
    mapping["server"] = mapping.get("server", {}) | SERVERS[server]
    user = {"master": {"impedance_matrix": MATRIX}, "link": {"loss": 0.3, "delay_s": 0.01}}
    mapping |= {"channel": channel, "dof": 3, "duration_s": 1.5, "user1": user}
    mapping["task"] = {"grip_s": 0.1, "grip_rise_s": 0.3, "move_s": 0.5, "sideways_m": 0.03}
    return parse_scenario(mapping)


def compare(scenario):
    assert can_run(scenario)
    left = run(scenario, session)
    was, now = golden.record_of(simulate_one(scenario)), golden.record_of(traces_of(left))
    assert golden.differences(was, now, 1e-9) == []


def test_compiled_it_is_the_same():
    settings = {"position": POSITIONS["adapts"]} | FILTERS["bank"]
    scenario = scenario_with("wifi_bursty", "strict", settings)
    one, other = run(scenario, session), run(scenario, compiled(session))
    for name, wanted, got in zip(one.book._fields, one.book, other.book, strict=True):
        scale = max(1.0, float(np.abs(wanted).max(initial=0.0)))
        assert np.abs(got - wanted).max(initial=0.0) <= 1e-12 * scale, name
