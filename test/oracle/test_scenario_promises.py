# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every scenario keeps what its file promises: simulated in full, judged as a session is."""

import functools

import numpy as np
import pytest

from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_analysis.transparency.transparency import ideal_of, transparency
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import scenarios
from pmwvc_core.simulation.session import simulate_one
from reproduction.local_model import swept

SHORT = "duration_s=6"  # they hold the cube, and begin to carry it
ONCE = "duration_s=12"  # there and back, and a second of rest


@functools.cache
def ran(name, *settings):
    """Return traces and summary of a scenario."""
    scenario = scenarios.load(name, settings_texts=settings)
    traces = simulate_one(scenario)
    return traces, summary(traces, scenario)


def forces(result):
    return [user["force_final_n"] for user in result["users"]]


@pytest.mark.parametrize("name", ["carry_0ms", "carry_16ms", "carry_24ms"])
def test_carrying_is_a_firm_grip_far_from_the_limits(name):
    _, result = ran(name, ONCE)
    assert result["stable"]
    assert result["object"]["position_final_m"] == pytest.approx(0.0, abs=0.001)
    assert result["object"]["path_error_rms_m"] < 0.002
    for user, force in zip(result["users"], forces(result), strict=True):
        assert user["passive"]
        assert 1.0 < abs(force) < 2.0
        assert user["force_peak_n"] < 0.6 * 3.3
        assert user["safety_events"] == 0


def test_the_cube_is_carried_there_and_back():
    traces, _ = ran("carry_16ms", ONCE)
    path = traces.server.x_o[:, 0]
    assert path.max() == pytest.approx(0.05, abs=0.002)
    assert path[0] == 0.0
    assert traces.server.contact[0][-1] and traces.server.contact[1][-1]


def test_delay_adds_distance_between_hand_and_avatar():
    """F tau / (2 b), with tau longer by twice the delay."""
    drifts = [ran(f"carry_{ms}ms", ONCE)[1]["users"][0] for ms in (0, 16, 24)]
    compliance = [user["drift_m"] / user["force_final_n"] for user in drifts]
    assert compliance[1] - compliance[0] == pytest.approx(0.032 / 50.0, rel=0.02)
    assert compliance[2] - compliance[0] == pytest.approx(0.048 / 50.0, rel=0.02)


def test_direct_coupling_works_without_delay_and_vibrates_with_it():
    assert ran("direct_0ms", SHORT)[1]["stable"]
    _, result = ran("direct_16ms", "duration_s=8")
    assert result["instability"] == "limited by safety"
    for user in result["users"]:
        assert user["safety_events"] > 3
        assert user["force_peak_n"] <= 3.3 * (1 + 1e-12)


def test_a_stiff_cube_needs_the_loop_to_be_solved():
    assert ran("stiff_24ms", SHORT)[1]["stable"]
    late = "server.coupling=one_step_delay"
    assert not ran("stiff_24ms", late, SHORT)[1]["stable"]


def test_controlled_forces_settle_at_one_newton_and_two_millimetres():
    """At other delays: ``test_reproduction.py``; the files differ in nothing else."""
    traces, result = ran("thesis_controlled_24ms", "duration_s=8")
    late = scenarios.load("thesis_controlled_24ms")
    for ms in (0, 16):
        one = scenarios.load(f"thesis_controlled_{ms}ms").flat()
        differ = {name for name, value in late.flat().items() if one[name] != value}
        assert differ == {"name", "description", "link.up.delay_s", "link.down.delay_s"}
    assert result["stable"]
    assert forces(result) == pytest.approx([1.0, -1.0], abs=0.001)
    for x_s, side in zip(traces.server.x_s, (-1, 1), strict=True):
        assert x_s[-1, 0] == pytest.approx(side * (0.03 - 0.002), abs=1e-5)
    assert np.abs(traces.server.x_o).max() < 1e-9


def test_three_hands_balance_over_unequal_links():
    _, result = ran("three_users", "duration_s=9")
    assert result["stable"]
    assert sum(forces(result)) == pytest.approx(0.0, abs=0.1)
    assert min(map(abs, forces(result))) > 0.5
    assert all(user["passive"] for user in result["users"])
    assert len({round(link["delay_s"]["p50"], 3) for link in result["links"]}) == 3


def test_the_wall_is_met_and_holds_the_hand():
    traces, result = ran("wall")
    assert result["stable"]
    (force,) = forces(result)
    contact = traces.server.contact[0]
    assert not contact[0] and contact[-1]
    depth = traces.server.x_s[0][-1, 0] + 0.03
    assert depth == pytest.approx(force / 1000.0, rel=0.01)


def test_a_slow_black_box_wall_is_rendered_and_the_published_compensation_makes_energy():
    """K T + 2 B < b: passive untreated, so the ledger has nothing to take. All compensations:
    ``property/test_black_box_passivity.py``, ``test_reproduction.py``.
    """
    traces, result = ran("wall_slow", "server.decoding=late", "server.compensation=ledger")
    server = traces.server
    assert result["stable"]
    assert forces(result)[0] == pytest.approx(0.95, abs=0.05)
    assert server.x_s[0][-1, 0] + 0.03 == pytest.approx(server.f_s[0][-1, 0] / 500.0)
    assert np.all(server.energy_u_s[0] - server.energy_v_s[0] >= 0.0)
    assert server.accounts["late_decoding"][-1] < -2e-4
    assert abs(server.accounts["withheld"][-1]) < 1e-9
    traces, _ = ran("wall_slow", "server.decoding=late", "server.compensation=printed")
    left = traces.server.energy_u_s[0] - traces.server.energy_v_s[0]
    assert left[-1] < -1e-3


def test_a_stiff_slow_wall_is_rendered_through_its_learned_slope():
    """K T = 40 N s/m, 2 B = 20, b = 25: decoded late its force collapses."""
    stiff = ("server.contact_stiffness=2000", "server.contact_damping=10")
    traces, result = ran("wall_slow", *stiff)
    assert result["stable"]
    assert forces(result)[0] == pytest.approx(0.97, abs=0.02)
    depth = traces.users[0].x_m[-1, 0] + 0.03
    assert depth < 1.7e-3
    assert result["users"][0]["environment_limited"] is None
    _, late = ran("wall_slow", *stiff, "server.decoding=late")
    assert late["instability"] == "environment lost"


def test_a_driven_wall_moves_the_hand_until_its_allowance_is_used_up():
    traces, result = ran("active_wall")
    server = traces.server
    granted, withheld = server.accounts["granted"], server.accounts["withheld"]
    assert result["stable"]
    assert result["users"][0]["environment_limited"]["energy_j"] == pytest.approx(withheld[-1])
    assert granted[-1] == pytest.approx(0.03)
    used_up = int(np.argmax(granted >= 0.03 - 1e-9))
    assert 5.0 < server.time_s[used_up] < 12.0
    assert withheld[used_up] < 0.003
    assert withheld[-1] > 0.01
    device, late = traces.users[0].x_m[:, 0], traces.users[0].time_s > 16.0
    assert np.ptp(device[late]) < 1e-3  # held, while the wall goes on
    assert np.ptp(device[~late]) > 0.015
    left = server.energy_u_s[0] - server.energy_v_s[0]
    assert np.all(left >= -granted - 1e-9)
    untreated, _ = ran("active_wall", "server.compensation=none", "duration_s=11")
    assert np.min(untreated.server.energy_u_s[0] - untreated.server.energy_v_s[0]) < -0.015


def test_recorded_hands_carry_the_cube_to_and_fro_twice():
    traces, result = ran("playback")
    assert result["stable"]
    path = traces.server.x_o[:, 0]
    assert path.max() == pytest.approx(0.02, abs=0.002)
    away = path > 0.01
    assert np.count_nonzero(away[1:] & ~away[:-1]) == 2


@pytest.mark.parametrize(
    ("name", "controller", "lasts_s"),
    [("carry_24ms", "virtual_coupling", 7.5), ("carry_24ms", "tdpa", 7.5),
     ("carry_24ms", "pspm", 9.0), ("carry_0ms", "tdpa", 7.5)],
)  # fmt: skip
def test_rivals_carry_the_cube_there_with_their_defaults(name, controller, lasts_s):
    settings = (f"controller={controller}", f"duration_s={lasts_s}")
    traces, result = ran(name, *settings)
    assert result["stable"]
    assert not inconsistencies(traces, scenarios.load(name, settings_texts=settings))
    assert traces.server.x_o.max() == pytest.approx(0.05, abs=0.002)
    for user in result["users"]:
        assert user["force_peak_n"] < 0.8 * 3.3
        assert user["safety_events"] == 0


def test_a_local_model_brings_the_first_resonance_nearer_to_the_ideal():
    """At rest the wall's 500 N/m are felt; the sweep shows both, as the model says."""
    scenario = scenarios.load("wall_local_model")
    traces, result = ran("wall_local_model")
    seen, modelled = swept(traces, scenario), transparency(scenario).rendered
    plain = scenarios.load("wall_local_model", settings_texts=("master.bank.kind=none",))
    without = transparency(plain).rendered
    ideal = transparency(ideal_of(scenario)).rendered.first_peak_hz
    assert result["stable"]
    assert result["users"][0]["safety_events"] == 0
    assert modelled.k_felt == pytest.approx(500.0, rel=0.01)
    for found in (seen, modelled):
        assert found.first_peak_hz == pytest.approx(5.2, abs=0.2)
        assert abs(ideal - found.first_peak_hz) < abs(ideal - without.first_peak_hz) - 0.8


def test_the_complementary_bank_of_the_local_model_is_passive():
    """The one that the dissertation prints is not: the control."""
    settings = (
        "master.bank.kind=complementary",
        "master.filter.kind=integrate_and_dump",
        "master.position.gain=0.0",
    )
    assert ran("wall_local_model", *settings)[1]["users"][0]["passive"]
    assert not ran("wall_local_model")[1]["users"][0]["passive"]


@pytest.mark.parametrize(
    ("name", "lasts_s"), [("internet", 11), ("reorder_storm", 9), ("blackout_2s", 14)]
)
def test_a_bad_network_makes_no_energy_on_the_strict_channel(name, lasts_s):
    traces, result = ran(name, f"duration_s={lasts_s}")
    assert result["stable"]
    assert all(user["passive"] for user in result["users"])
    told = {link["name"]: link for link in result["links"]}
    assert (
        sum(link["lost"] + link["reordered"] + link["duplicated"] for link in told.values()) > 50
    )
    for user in traces.users:
        limit = 2000.0 * user.tick_s  # safety.max_slew
        assert np.abs(np.diff(user.f_applied[:, 0])).max() <= limit + 1e-9
