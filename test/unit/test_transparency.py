# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rendering of a link against closed forms and against simulated sessions."""

import dataclasses

import numpy as np
import pytest
from support.pressed_wall import wall

from pmwvc_analysis.models import linearize
from pmwvc_analysis.transparency import frequency
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


def test_nonlinear_devices_are_refused_with_the_way_out():
    scenario = wall()
    rubs = dataclasses.replace(scenario.users[0].device, friction=0.1)
    users = (dataclasses.replace(scenario.users[0], given_device=rubs),)
    with pytest.raises(PmwvcError, match="friction"):
        transparency(dataclasses.replace(scenario, users=users))
