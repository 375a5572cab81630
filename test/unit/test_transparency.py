# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rendering of a link against closed forms and simulated sessions, whose admittance is the
model's.
"""

import numpy as np
import pytest
from support.pressed_wall import wall

from pmwvc_analysis.models import linearize
from pmwvc_analysis.transparency import frequency
from pmwvc_analysis.transparency.pressing import pressing
from pmwvc_analysis.transparency.transparency import ideal_of, transparency
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.session import simulate_one
from reproduction.sweep import TRUSTED, measure

GENTLE = {"safety.max_force": 20.0, "safety.max_slew": 20000.0, "operator.force": 0.2}
CHIRP = {
    "operator.kind": "chirp",
    "operator.frequency_hz": 0.5,
    "operator.frequency_end_hz": 30.0,
    "operator.sweep_s": 6.0,
    "duration_s": 18.5,
    "link.delay_s": 0.008,
}


def recorded(changes):
    scenario = wall(**GENTLE, **changes)
    return scenario, simulate_one(scenario).users[0]


@pytest.fixture(scope="module")
def chirp():
    return recorded(CHIRP)


def distance(scenario, found):
    exact = frequency.response(linearize.build(scenario), found.frequency_hz)
    return np.abs(found.admittance - exact) / np.abs(exact)


def test_a_chirp_shows_the_admittance_of_the_model(chirp):
    scenario, user = chirp
    found = measure(user, scenario.users[0])
    assert np.median(distance(scenario, found)) < 0.01
    assert np.median(found.coherence) > 0.999
    assert found.frequency_hz.min() >= 0.5
    assert found.frequency_hz.max() <= 30.0
    other = wall(**GENTLE, **CHIRP | {"server.contact_stiffness": 400.0})  # the control
    assert np.median(distance(other, found)) > 0.1


def test_of_two_users_one_pushes_alone():
    changes = GENTLE | CHIRP | {"users": 2, "server.environment": "cube"}
    scenario = parse_scenario(
        wall().to_dict() | {"users": 2},
        overrides=changes | {"user2.operator.kind": "none", "server.object_damping": 5.0},
    )
    traces = simulate_one(scenario)
    found = measure(traces.users[0], scenario.users[0])
    model = linearize.build(scenario)
    alone, pressed = (
        frequency.response(model, found.frequency_hz, forces=forces)
        for forces in ([1.0, 0.0], pressing(scenario, 0))
    )
    trusted = found.coherence >= TRUSTED
    error = np.abs(found.admittance - alone)[trusted] / np.abs(alone)[trusted]
    assert np.median(error) < 0.01
    wrong = np.abs(found.admittance - pressed)[trusted] / np.abs(pressed)[trusted]
    assert np.max(wrong) > 5.0


@pytest.mark.parametrize("hertz", [1.25, 12.5])
@pytest.mark.parametrize(
    "changes",
    [
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
            "duration_s": 7.0,
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
    with pytest.raises(PmwvcError, match=r"not stable \(spectral radius .*pmwvc stability"):
        transparency(late)


def test_an_ideal_that_is_not_stable_is_left_out_and_reported():
    found = transparency(wall(**{"server.contact_stiffness": 1e6}), np.array([1.0]))
    assert found.ideal.k_felt is None
    assert np.isnan(found.ideal_admittance).all()
    assert any("ideal coupling is not stable" in note for note in found.notes)
