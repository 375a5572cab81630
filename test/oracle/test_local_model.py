# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. E by two routes: the simulator's objects, and the loop written out."""

import math

import numpy as np
import pytest
from support.linear_loops import SETTLED, simulated
from support.local_loop import FIRST_ORDER, TABLE_1, TICK_S, Loop

from pmwvc_core.scenario.reader import parse_scenario


def scenario(loop):
    """The same loop for the simulator."""
    high = loop.high or TABLE_1
    names = ("high_pass_hz", "high_pass_db", "high_stop_hz", "high_stop_db")
    return parse_scenario(
        {
            "name": "local",
            "duration_s": 1.0,
            "controller": "pmwvc",
            "channel": "plain",
            "users": 1,
            "master": {
                "impedance": loop.b,
                "rate_drop": 20,
                "hold": "zoh",
                "filter": {"kind": "butterworth", "pass_hz": 25.0, "stop_hz": 50.0},
                "bank": dict(zip(names, high, strict=True))
                | {"kind": "dissertation" if loop.high else "none"},
                "local_model": {"stiffness": loop.stiffness, "damping": loop.damping},
                "position": {"feedback": "printed", "gain": loop.k_p},
            },
            "device": {"mass": loop.mass, "damping": loop.damping_hd, "workspace_m": 1e9},
            "safety": {"timeout_s": 5.0},
            "operator": {"kind": "none"},
            "server": {
                "environment": "wall",
                "contact": "bilateral",
                "contact_stiffness": 500.0,
                "contact_damping": 1.0,
                "period_s": 0.02,
            },
            "task": {"kind": "free"},
        }
    )


def ideal_peak_hz(loop):
    """The same wall at every instant: 1/|K - m w^2 + j w (b_hd + B)| is largest there."""
    damping = loop.damping_hd + 1.0
    return math.sqrt(500.0 / loop.mass - damping**2 / (2.0 * loop.mass**2)) / (2.0 * math.pi)


def threshold(**varied):
    """Least damping of the local model with which the loop is stable; None if 60 does not do."""
    low, high = 0.0, 60.0
    if Loop(damping=high, **varied).radius() >= 1.0:
        return None
    while high - low > 1e-5:
        middle = 0.5 * (low + high)
        stable = Loop(damping=middle, **varied).radius() < 1.0
        low, high = (low, middle) if stable else (middle, high)
    return high


@pytest.mark.parametrize(
    "loop",
    [
        Loop(damping=5.0),
        Loop(damping=8.0, high=FIRST_ORDER, k_p=20.0),
        Loop(damping=1.0),
        Loop(high=None, k_p=20.0),
    ],
    ids=["table", "first order", "unstable", "no bank"],
)
def test_the_simulator_moves_as_the_loop_written_out(loop):
    forces = np.random.default_rng(5).normal(size=400)
    traces = simulated(scenario(loop), forces[np.newaxis])
    x = np.ravel(traces.users[0].x_m)[SETTLED:]
    expected = loop.trace(forces)
    np.testing.assert_allclose(x - x[0], expected, atol=1e-8 * np.abs(expected).max())


def test_the_local_model_has_to_be_damped_because_the_device_is_held():
    """B_lm >= 3.0 N s/m with the midpoint rule. It is G = theta K T_c + B_lm that has to be 3.22
    N s/m, so the rule shifts B_lm by half of K T_c; with a force one tick late nothing helps.
    """
    found = {theta: threshold(theta=theta) for theta in (0.0, 0.5, 1.0)}
    assert found[0.5] == pytest.approx(2.9655, abs=1e-3)
    for theta, damping in found.items():
        assert damping + theta * 500.0 * TICK_S == pytest.approx(3.2155, abs=1e-3)
    assert threshold(theta=0.5, late=True) is None


def test_as_published_the_local_model_of_app_e_is_unstable():
    """K_lm = 500 and B_VE = 1 in both: not stable by any rule; the scenario has B_lm = 8."""
    assert all(Loop(damping=1.0, theta=theta).radius() > 1.4 for theta in (0.0, 0.5, 1.0))
    assert Loop(damping=8.0, high=FIRST_ORDER, k_p=20.0).radius() < 0.95


def test_the_high_pass_filter_of_table_1_lets_nothing_of_the_first_resonance_through():
    """Its attenuation there is over 100 dB: the bank does not move the resonance. (App. E, Fig.
    6 shows it moved.)
    """
    without, table = Loop(high=None, k_p=20.0), Loop(k_p=20.0)
    assert table.first_peak_hz() == pytest.approx(without.first_peak_hz(), abs=0.05)
    assert ideal_peak_hz(table) == pytest.approx(10.9, abs=0.1)


def test_a_high_pass_filter_that_reaches_down_brings_the_first_resonance_nearer_to_the_ideal():
    without, low = Loop(high=None, k_p=20.0), Loop(damping=8.0, high=FIRST_ORDER, k_p=20.0)
    ideal = ideal_peak_hz(low)
    gained = abs(without.first_peak_hz() - ideal) - abs(low.first_peak_hz() - ideal)
    assert gained > 0.9
    size = [abs(loop.admittance(loop.first_peak_hz())[0]) for loop in (without, low)]
    assert size[1] < 0.6 * size[0]


def test_position_feedback_renders_the_stiffness_of_the_environment():
    """Without: 357 N/m of 500."""
    felt = {k_p: 1.0 / abs(Loop(k_p=k_p).admittance(0.02)[0]) for k_p in (0.0, 20.0)}
    assert felt[0.0] == pytest.approx(357.2, abs=0.5)
    assert felt[20.0] == pytest.approx(500.0, rel=0.02)
