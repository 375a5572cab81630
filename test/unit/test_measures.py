# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The measures of a comparison, each against a session made to have it."""

import numpy as np
import pytest
from support.plain import load

from pmwvc_analysis.compare.measures import (
    MEASURES,
    Compared,
    force_error,
    measured,
    measures,
    rendering,
)
from pmwvc_analysis.transparency.transparency import ideal_of
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.session import simulate_one

BASE = {
    "name": "short",
    "duration_s": 2.0,
    "controller": "pmwvc",
    "channel": "plain",
    "users": 2,
    "server": {"contact": "bilateral"},
    "task": {"kind": "hold", "grip_s": 0.1, "grip_rise_s": 0.2},
}


@pytest.fixture
def session():
    scenario = parse_scenario(BASE)
    return simulate_one(scenario), scenario


def test_a_passive_session_has_every_measure_and_energy_given_out_is_seen(session):
    traces, scenario = session
    found = measures(traces, scenario)
    assert set(found) == set(MEASURES)
    assert found["passive"] is True
    assert found["energy_min_j"] == pytest.approx(0.0, abs=1e-9)
    traces.server.energy_u_s[0][100:] += 0.25
    assert measures(traces, scenario)["energy_min_j"] < -0.2


def test_force_error_and_offset_are_those_that_a_session_was_given(session):
    traces, scenario = session
    user, server = traces.users[0], traces.server
    user.f_applied[:], server.f_s[0][:] = 0.7, 0.2
    error = force_error(user, server, 0)
    assert len(error) == (server.state[0] == 2).sum() > 200
    np.testing.assert_allclose(error, 0.5)
    for each, x_s, apart in zip(traces.users, server.x_s, (3e-3, 4e-3), strict=True):
        each.x_m[:], x_s[:] = 0.0, apart
        x_s[: len(x_s) // 2] = 0.0
        traces.packets[f"/server/{each.name}/wave_down"].position[:] = x_s
    found = measures(traces, scenario)["coherency_rms_m"]  # over all users
    assert found == pytest.approx(np.sqrt((9e-6 + 16e-6) / 4), rel=0.02)


@pytest.mark.parametrize("compensation", ["none", "printed"])
def test_energy_that_the_servers_port_generates_is_in_the_balance(compensation):
    """A stiff wall decoded a step late: its channels are passive, its port is not."""
    scenario = load(
        "wall_slow",
        settings_texts=[
            "server.contact_stiffness=2000",
            "server.contact_damping=10",
            "server.decoding=late",
            f"server.compensation={compensation}",
        ],
        duration_s=4.0,
    )
    found = measures(simulate_one(scenario), scenario)
    assert found["energy_min_j"] < -0.05
    assert found["passive"] is False
    assert found["active_part"] == "server with its environment"


@pytest.mark.parametrize(
    ("changes", "low", "high"),
    [
        ({"device.friction": 0.1}, None, None),  # no linear model
        ({"server.coupling": "one_step_delay"}, 1e3, 1e4),
    ],
)
def test_the_largest_stiffness_is_that_of_the_model_where_there_is_one(changes, low, high):
    scenario = parse_scenario(BASE, overrides=changes, duration_s=0.5)
    found = measured(Compared("", {}, simulate_one(scenario), scenario)).measures["k_max"]
    assert found is None if low is None else low < found < high


WALL = {"environment": "wall", "contact": "bilateral", "contact_stiffness": 800.0}
ALONE = BASE | {"users": 1, "server": WALL, "task": {"kind": "free"}}


def test_what_a_press_shows_is_what_the_model_gives():
    """Two routes: the exact model, and a press in virtual time."""
    scenario = parse_scenario(ALONE)
    model = rendering(scenario, live=False)
    # Nothing of the model is asked for what is not linear; with friction of nearly zero the motion
    # is the same, and the press has to tell.
    pressed = rendering(parse_scenario(ALONE, overrides={"device.friction": 1e-9}), live=False)
    assert (model["k_felt_from"], pressed["k_felt_from"]) == ("model", "press")
    assert pressed["first_peak_hz"] is None
    ideal = rendering(ideal_of(scenario), live=False)
    assert ideal["k_felt"] == pytest.approx(800.0, rel=1e-3)
    assert pressed["k_felt"] == pytest.approx(model["k_felt"], rel=1e-3)
