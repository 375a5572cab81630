# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops with long delays: counted windings against the eigenvalues of the matrix with every packet
as a state, and answers where that matrix would not fit.
"""

import math

import numpy as np
import pytest
from support import plain as scenarios
from support.linear_loops import scenario

from pmwvc_analysis.models import linearize, long_delays, stability
from pmwvc_analysis.models.answer import answer
from pmwvc_analysis.models.any_delay import any_delay
from pmwvc_analysis.models.long_delays import Long
from pmwvc_analysis.models.loop import loop_of
from pmwvc_analysis.prediction.prediction import prediction
from pmwvc_analysis.transparency.transparency import transparency, untouched
from pmwvc_core.scenario.names import varied

CASES = {
    "equal users": {},
    "a wall": {"users": 1, "server__environment": "wall"},
    "unstable": {"server__coupling": "one_frame_late", "server__contact_stiffness": 1500.0},
    "another filter and delay": {
        "user2__master__filter__kind": "integrate_and_dump",
        "user2__master__filter__pole_rad_s": None,
        "user2__link__delay_s": 0.31,
    },
    "ends of different impedance": {"user1__server__impedance": 40.0},
    "no contact": {"server__contact_stiffness": 0.0, "server__contact_damping": 0.0},
    "more server steps than frames": {"server__period_s": 0.004},
    "frames of two lengths": {"user2__master__rate_drop": 4},
    "every tick": {"master__rate_drop": 1, "server__period_s": 0.001, "link__delay_s": 0.03},
    "direct": {"controller": "direct"},
}


def both_ways(monkeypatch, of, *, live):
    found = []
    for most in (10**9, 0):
        monkeypatch.setattr(long_delays, "LARGEST_DENSE", most)
        found.append(stability.radii(of, live=live)[0])
    return found


@pytest.mark.parametrize("live", [False, True])
@pytest.mark.parametrize("case", CASES)
def test_the_radius_is_that_of_the_matrix_with_all_packets(monkeypatch, case, live):
    of = scenario(**{"link__delay_s": 0.17} | CASES[case])
    dense, counted = both_ways(monkeypatch, of, live=live)
    # Growth over the delay: the radius itself is near to 1 for any long one.
    assert math.log(counted) == pytest.approx(math.log(dense), rel=1e-4, abs=1e-9)


def test_random_loops_have_the_radius_of_the_matrix(monkeypatch):
    draw = np.random.default_rng(19)
    for _ in range(4):
        of = scenario(
            master__impedance=float(draw.uniform(10, 60)),
            server__impedance=float(draw.uniform(10, 60)),
            device__mass=float(draw.uniform(0.1, 0.5)),
            device__damping=float(draw.choice([0.0, 0.5])),
            user2__device__mass=float(draw.uniform(0.1, 0.5)),
            server__coupling=str(draw.choice(["implicit", "one_step_delay", "one_frame_late"])),
            server__contact_stiffness=float(np.exp(draw.uniform(3, 8))),
            server__contact_damping=float(draw.uniform(0.0, 15.0)),
            link__up__delay_s=float(draw.uniform(0.05, 0.2)),
            link__down__delay_s=float(draw.uniform(0.05, 0.2)),
        )
        dense, counted = both_ways(monkeypatch, of, live=bool(draw.integers(2)))
        assert math.log(counted) == pytest.approx(math.log(dense), rel=1e-4, abs=1e-9)


def test_the_largest_stiffness_is_that_of_the_matrix(monkeypatch):
    of = scenario(link__delay_s=0.1, server__coupling="one_step_delay", device__damping=0.3)
    found = []
    for most in (10**9, 0):
        monkeypatch.setattr(long_delays, "LARGEST_DENSE", most)
        found.append(stability.k_max(of).first)
    assert found[1] == pytest.approx(found[0], rel=1e-3)


def test_runs_of_a_batch_are_those_alone():
    of = scenario(link__delay_s=2.0, device__damping=0.2)
    runs = [varied(of, "server.contact_stiffness", k) for k in (50.0, 500.0, 5000.0)]
    together = stability.radii(*runs)
    alone = [stability.radii(run)[0] for run in runs]
    np.testing.assert_allclose(together, alone, rtol=1e-12)


def test_radius_and_count_call_the_same_runs_stable_where_rigid_motions_are_double():
    """At the edge, where the rounding of a double eigenvalue hides slow growth."""
    of = scenarios.load(
        "carry_16ms",
        settings_texts=[
            *("controller=direct", "link.delay_s=0.3", "device.damping=0"),
            *("server.object_damping=0", "server.contact_damping=0.1"),
        ],
    )

    def at(stiffness):
        return Long(loop_of(*(varied(of, "server.contact_stiffness", k) for k in stiffness)))

    low, high, within = 0.14, 0.17, []
    while not within:
        loops = at(np.linspace(low, high, 12))
        assert min(loci.at_one for loci in loops.loci) > 1
        grows = np.array([loci.log_radius() for loci in loops.loci])
        within = list(np.flatnonzero((grows > 1e-8) & (grows < 0.9 * long_delays.DOUBLE)))
        edge = int(np.flatnonzero(np.diff(np.sign(grows)))[0])
        low, high = np.linspace(low, high, 12)[edge : edge + 2]
        told = list(map(linearize.stable, loops.radii()))
        np.testing.assert_array_equal(told, loops.stable())
    assert all(told[run] for run in within)


@pytest.mark.parametrize("delay_s", [2.0, 5.0, 60.0])
@pytest.mark.parametrize("name", ["carry_16ms", "three_users", "wall"])
def test_any_allowed_delay_is_answered(name, delay_s):
    of = scenarios.load(name, settings_texts=[f"link.delay_s={delay_s}", "device.damping=0.2"])
    model = Long(loop_of(of))
    assert model.loci[0].size[1] < 40  # whatever the delay
    assert model.count > 2.0 * delay_s / 0.008
    found = answer(of)
    assert found["stable"] and found["spectral_radius"] <= 1.0 + linearize.ROUNDING
    assert any_delay(of).proved, "so it had to be stable"
    assert prediction(of, live=True)["stable"]


def test_a_long_way_renders_as_its_lag_says():
    of = scenarios.load("wall", settings_texts=["link.delay_s=2"])
    found = transparency(of, np.array([0.3])).rendered
    assert found.k_felt == pytest.approx(2.0 * 25.0 / 4.0, rel=0.05)


def test_free_motion_of_undamped_devices_grows_as_slowly_as_its_gain_gives():
    """1.0014 once around at 6 Hz: ln(radius) = ln(gain)/delay for a long one."""
    of = untouched(scenarios.load("carry_16ms", settings_texts=["link.delay_s=10"]))
    gain = any_delay(of).gain
    frames = 20.0 / 0.008
    assert math.log(stability.radii(of)[0]) == pytest.approx(math.log(gain) / frames, rel=0.01)
