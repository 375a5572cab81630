# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Verdicts on the stability of simulated sessions, against the exact model."""

import numpy as np
import pytest
from support import linear_loops
from support import plain as scenarios

from pmwvc_analysis.models.stability import radii
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.scenario.names import varied
from pmwvc_core.simulation.session import simulate_one


def pressed(force_n, frequency_hz, stiffness, period_s):
    """A hand that pushes and pulls at a bilateral wall."""
    rate_drop = round(period_s * 1000)
    return scenarios.load(
        "wall_filtered",
        settings_texts=[
            f"operator.force={force_n}", f"operator.frequency_hz={frequency_hz}",
            f"server.contact_stiffness={stiffness}", f"server.period_s={period_s}",
            f"master.rate_drop={rate_drop}", "master.velocity_filter.kind=none",
            "device.velocity=exact", "device.encoder_step_m=0", "safety.max_force=20",
            "safety.max_slew=20000", "server.coupling=one_frame_late",
        ],
        duration_s=5.0,
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(8))
def test_a_driven_loop_is_stable_where_its_eigenvalues_are_however_hard_it_is_driven(seed):
    """The images of the drive at the packet rate grow with it; the control is an unstable loop."""
    rng = np.random.default_rng(seed)
    period_s = float(rng.choice([0.008, 0.01, 0.02]))
    scenario = pressed(
        float(rng.uniform(0.5, 4.0)), float(rng.uniform(1.0, 7.0)),
        float(rng.uniform(50.0, 3000.0)), period_s,
    )  # fmt: skip
    radius = float(radii(scenario)[0]) ** (1.0 / period_s)  # per second
    if 0.2 < radius < 3.0:
        return  # neither dies out nor grows within the session
    found = verdict(simulate_one(scenario), scenario)
    assert found.stable is (radius < 1.0), found.why


def slow(seed, per_s):
    """Return a session of a wall whose slowest motion grows by so much, and its scenario."""
    rng = np.random.default_rng(seed)
    frame = int(rng.choice([4, 8]))
    base = linear_loops.scenario(
        users=1,
        master__rate_drop=frame,
        server__period_s=frame / 1000,
        link__delay_s=float(rng.choice([0.008, 0.016, 0.024])),
        server__environment="wall",
        server__coupling="one_frame_late",
        server__contact_damping=float(rng.uniform(0.5, 3.0)),
        device__damping=0.3,
    )

    def rates(stiffness):
        found = radii(*(varied(base, "server.contact_stiffness", k) for k in stiffness))
        return np.log(found) / (frame / 1000)

    low, high = 100.0, 1000.0
    for _ in range(5):
        grid = np.linspace(low, high, 20)
        above = int(np.argmax(rates(grid) > per_s))
        low, high = grid[above - 1], grid[above]
    scenario = varied(base, "server.contact_stiffness", float(low))
    push = np.zeros((1, 8000))
    push[0, :300] = 0.5
    return linear_loops.simulated(scenario, push), scenario


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_a_decay_slower_than_a_session_shows_is_no_sustained_oscillation(seed):
    """The control is the same motion beside a model that has it grow."""
    traces, scenario = slow(seed, per_s=-0.004 - 0.004 * seed)
    found = verdict(traces, scenario)
    assert (found.stable, found.instability) == (None, None)
    assert "the exact model, hands off, decays by 0.0" in found.why
    stiffer = varied(
        scenario, "server.contact_stiffness", 1.3 * scenario.users[0].contact.contact_stiffness
    )
    assert verdict(traces, stiffer).instability == "sustained oscillation"


def test_an_oscillation_that_lasts_beside_a_model_that_has_it_die_out_says_so():
    traces, scenario = slow(0, per_s=0.002)
    softer = varied(
        scenario, "server.contact_stiffness", 0.5 * scenario.users[0].contact.contact_stiffness
    )
    found = verdict(traces, softer)
    assert found.instability == "sustained oscillation"
    assert "; the exact model, hands off, decays by " in found.why
    assert "decays" not in verdict(traces, scenario).why
