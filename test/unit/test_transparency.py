# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rendering of a link against closed forms and against simulated sessions."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.pressed_wall import wall

from pmwvc_analysis.models import linearize
from pmwvc_analysis.transparency import frequency
from pmwvc_analysis.transparency.pressing import pressing
from pmwvc_analysis.transparency.transparency import ideal_of, transparency
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.session import simulate_one


def cube(**overrides):
    changes = {"users": 2, "server.environment": "cube", **overrides}
    return parse_scenario(wall().to_dict() | {"users": 2}, overrides=changes)


def lag_s(scenario):
    """tau: filter, a tick to the packet, hold, network both ways (docs/theory.md, section 11)."""
    user = scenario.users[0]
    p = np.exp(-user.master.filter.pole_rad_s * 1e-3)
    m = user.master.rate_drop
    hold = (m - 1) if user.master.hold == "foh" else (m - 1) / 2
    network = user.link_up.delay_s + user.link_down.delay_s
    return (p / (1 - p) + 1 + hold) * 1e-3 + network


@settings(max_examples=25)
@given(
    impedance=st.floats(10.0, 60.0),
    stiffness=st.floats(100.0, 5000.0),
    pole=st.floats(20.0, 80.0),
    frames=st.integers(0, 3),
    make=st.sampled_from([wall, cube]),
)
def test_contact_and_link_are_springs_in_series_and_the_link_has_the_mass_b_tau_half(
    impedance, stiffness, pole, frames, make
):
    scenario = make(
        **{
            "master.impedance": impedance,
            "master.filter.kind": "first_order",
            "master.filter.pole_rad_s": pole,
            "server.contact_stiffness": stiffness,
            "link.delay_s": frames * 0.008,
        }
    )
    tau, mass = lag_s(scenario), scenario.users[0].device.mass
    felt = transparency(scenario, np.array([1.0])).rendered
    assert felt.admittance_dc == pytest.approx(1 / stiffness + tau / (2 * impedance), rel=1e-4)
    assert felt.k_felt == pytest.approx(1 / felt.admittance_dc)
    # a damped device adds a little inertia of its own, as the force is held: b_hd T_c/2
    assert felt.mass_felt == pytest.approx(mass + impedance * tau / 2 + 0.0005, rel=1e-4)


def test_the_steps_of_a_zero_order_hold_shift_the_lag_by_a_fraction_of_a_tick():
    """They come back through the filter, sampled at their end and not at their mean."""
    filtering = {"master.filter.kind": "first_order", "master.filter.pole_rad_s": 50.0}
    scenario = wall(**filtering, **{"master.hold": "zoh"})
    felt, b = transparency(scenario, np.array([1.0])).rendered, scenario.users[0].master.impedance
    tau = 2 * b * (felt.admittance_dc - 1 / 800.0)
    assert 0.0 < tau - lag_s(scenario) < 0.5e-3


def test_the_springs_and_the_mass_of_the_link_make_its_impedance():
    scenario = wall(
        **{"server.contact_stiffness": 1e5, "link.delay_s": 0.008, "device.damping": 0}
    )
    felt = transparency(scenario, np.array([1.0])).rendered
    b = scenario.users[0].master.impedance
    channel = 1 / (felt.admittance_dc - 1e-5)
    assert channel * (felt.mass_felt - 0.2) == pytest.approx(b**2, rel=1e-5)


@pytest.mark.parametrize("hertz", [1.25, 5.0, 12.5])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"link.delay_s": 0.016, "master.hold": "foh"},
        {"server.coupling": "one_step_delay", "server.contact_stiffness": 300.0},
        {"controller": "direct", "master.rate_drop": 4, "server.period_s": 0.004},
        {"server.period_s": 0.004, "master.rate_drop": 8},
    ],
)
def test_the_response_is_what_a_simulated_session_swings_to(hertz, changes):
    scenario = wall(
        **changes,
        **{
            "duration_s": 10.0,
            "operator.kind": "sinusoid",
            "operator.force": 0.2,
            "operator.frequency_hz": hertz,
            "safety.max_force": 20.0,
            "safety.max_slew": 20000.0,
        },
    )
    user = simulate_one(scenario).users[0]
    window = slice(-3200, None)  # a whole number of periods and of frames
    turn = np.exp(-2j * np.pi * hertz * user.time_s[window])
    swing = np.sum(user.x_m[window, 0] * turn) / np.sum(user.f_h[window, 0] * turn)
    model = linearize.build(scenario)
    (found,) = frequency.response(model, np.array([hertz]))
    assert abs(found - swing) < 1e-4 * abs(swing)


def test_two_users_who_press_alike_meet_a_wall():
    alone, opposite = (transparency(make(), np.geomspace(0.5, 100, 40)) for make in (wall, cube))
    np.testing.assert_allclose(opposite.admittance, alone.admittance, rtol=1e-6)
    lonely = transparency(wall(**{"server.environment": "cube"}), np.array([1.0]))
    assert lonely.rendered.k_felt is None
    assert any("keeps moving" in note for note in lonely.notes)


def test_one_presses_against_all_on_the_other_side():
    scenario = parse_scenario(cube().to_dict() | {"users": 3})
    assert [user.side for user in scenario.users] == [-1, 1, -1]
    assert pressing(scenario, 1)[:, 0].tolist() == [-0.5, 1.0, -0.5]
    assert pressing(scenario, 0)[:, 0].tolist() == [1.0, -1.0, 0.0]


def test_impedance_and_admittance_are_each_others_inverse():
    found = transparency(wall(), np.array([2.0, 20.0]))
    velocity = 2j * np.pi * found.frequency_hz * found.admittance
    np.testing.assert_allclose(found.impedance * velocity, 1.0)


def test_the_ideal_is_the_contact_itself():
    found = transparency(wall(), np.array([0.5, 2.0]))
    assert found.ideal.k_felt == pytest.approx(800.0, rel=1e-6)
    assert found.ideal.b_felt == pytest.approx(5.0 + 1.0, rel=1e-6)
    assert found.ideal.mass_felt == pytest.approx(0.2, rel=5e-3)
    omega = 2 * np.pi * found.frequency_hz
    contact = 1 / (800.0 + 6.0j * omega - 0.2 * omega**2)
    np.testing.assert_allclose(np.abs(found.ideal_admittance), np.abs(contact), rtol=3e-3)
    perfect = ideal_of(wall(**{"link.delay_s": 0.1}))
    assert perfect.users[0].link_up.delay_s == 0.0
    assert perfect.users[0].master.rate_drop == 1


@pytest.mark.parametrize("frames", [0, 1, 9])
@pytest.mark.parametrize("make", [wall, cube])
def test_delay_lines_put_in_before_solving_change_nothing(frames, make):
    model = linearize.build(make(**{"link.delay_s": 0.008 * frames}))
    hertz = np.array([0.7, 5.0, 44.0])
    found = frequency.response(model, hertz)
    ticks = model.ticks
    for value, f in zip(found, hertz, strict=True):
        angle = 2 * np.pi * f * model.loop.tick_s
        wave = np.zeros(len(model.loop.lines) * ticks, dtype=complex)
        wave[:ticks] = np.exp(1j * angle * np.arange(ticks))
        whole = np.exp(1j * angle * ticks) * np.eye(len(model.states)) - model.transition
        state = np.linalg.solve(whole, model.inputs @ wave)
        x = model.outputs["x"].state @ state + model.outputs["x"].through @ wave
        assert abs(value - np.mean((x * wave.conj())[:ticks])) < 1e-9 * abs(value)


def test_images_of_rest_are_no_obstacle():
    model = linearize.build(wall())
    at, beside = frequency.response(model, np.array([125.0, 125.001]))
    assert abs(at - beside) < 1e-3 * abs(at)


def test_the_first_peak_is_the_highest_point_around_it():
    scenario = wall()
    found = transparency(scenario)
    model = linearize.build(scenario)
    peak = found.rendered.first_peak_hz
    size = np.abs(frequency.response(model, peak * np.array([0.98, 1.0, 1.02])))
    assert size[1] > size[0]
    assert size[1] > size[2]
    assert transparency(wall(**{"device.damping": 200.0})).rendered.first_peak_hz is None


def test_what_is_not_stable_has_no_response():
    late = wall(**{"server.coupling": "one_step_delay", "server.contact_stiffness": 50000.0})
    with pytest.raises(PmwvcError, match=r"not stable \(spectral radius .*implicit"):
        transparency(late)


def test_an_ideal_that_is_not_stable_is_left_out_and_reported():
    found = transparency(wall(**{"server.contact_stiffness": 1e6}), np.array([1.0]))
    assert found.ideal.k_felt is None
    assert np.isnan(found.ideal_admittance).all()
    assert any("ideal coupling is not stable" in note for note in found.notes)


def test_live_phases_lower_the_rendered_stiffness():
    simulated, live = (
        transparency(wall(), np.array([1.0]), live=live).rendered.admittance_dc
        for live in (False, True)
    )
    b = wall().users[0].master.impedance
    assert live - simulated == pytest.approx(0.004 / (2 * b), rel=1e-4)


def test_nonlinear_devices_are_refused_with_the_way_out():
    scenario = wall()
    rubs = dataclasses.replace(scenario.users[0].device, friction=0.1)
    users = (dataclasses.replace(scenario.users[0], device=rubs),)
    with pytest.raises(PmwvcError, match="friction"):
        transparency(dataclasses.replace(scenario, users=users))
