# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Transparency and prediction where an impedance matrix couples the axes, by independent routes:
the simulator under forces along all axes, and the principal axes, each with a number for B.
"""

import numpy as np
import pytest
from support import linear_loops
from support.strategies import text_of

from pmwvc_analysis.models import linearize
from pmwvc_analysis.models.any_delay import any_delay
from pmwvc_analysis.models.stability import k_max
from pmwvc_analysis.prediction.prediction import prediction
from pmwvc_analysis.transparency import frequency
from pmwvc_analysis.transparency.pressing import pressing
from pmwvc_analysis.transparency.transparency import transparency

TURN = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
EIGENVALUES = (30.0, 12.0)
HERTZ = np.array([0.3, 2.0, 7.0, 19.0, 61.0])


MATRIX = text_of(TURN @ np.diag(EIGENVALUES) @ TURN.T)
OTHER = "25 -7; -7 16"  # has other principal axes


def coupled(**values):
    return linear_loops.scenario(dof=2, master__impedance_matrix=MATRIX, **values)


@pytest.mark.parametrize(
    "values",
    [
        {"link__delay_s": 0.008},
        {"server__impedance_matrix": OTHER, "server__coupling": "one_step_delay"},
    ],
)
def test_the_model_moves_as_the_simulator_under_forces_along_all_axes(values):
    scenario = coupled(**values)
    rng = np.random.default_rng(3)
    swing = np.sin(2.0 * np.pi * np.multiply.outer(np.arange(160) * 1e-3, rng.uniform(1, 6, 4)))
    forces = 0.3 * np.moveaxis(swing.reshape(160, 2, 2), 1, 0)
    traces = linear_loops.simulated(scenario, forces)
    model = linear_loops.modelled(linearize.build(scenario), forces)
    for index, user in enumerate(traces.users):
        x = user.x_m[linear_loops.SETTLED :]
        np.testing.assert_allclose(x - x[0], model["x"][index], atol=1e-12)
        np.testing.assert_allclose(user.f_m[linear_loops.SETTLED :], model["f"][index], atol=1e-9)
    assert np.ptp(model["x"][0], axis=0).min() > 1e-4  # both axes move


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("environment", ["wall", "cube"])
def test_an_admittance_is_that_of_the_principal_axes(axis, environment):
    """With B = sum of lambda_i e_i e_i^T: x/f along a is the sum of (a . e_i)^2 (x/f)_i."""
    values = {"server__environment": environment, "link__delay_s": 0.008}
    of = coupled(**values)
    found = transparency(of, HERTZ, axis=axis)
    numbers = [linear_loops.scenario(master__impedance=b, **values) for b in EIGENVALUES]
    each = [transparency(number, HERTZ) for number in numbers]
    share = TURN[axis] ** 2
    expected = share @ [one.admittance for one in each]
    np.testing.assert_allclose(found.admittance, expected, rtol=1e-8)
    at_rest = share @ [one.rendered.admittance_dc for one in each]
    assert found.rendered.admittance_dc == pytest.approx(at_rest, rel=1e-6)
    inertia = share @ [1.0 / one.rendered.mass_felt for one in each]
    assert found.rendered.mass_felt == pytest.approx(1.0 / inertia, rel=1e-4)
    np.testing.assert_allclose(found.ideal_admittance, each[0].ideal_admittance, rtol=1e-9)
    across = frequency.response(
        linearize.build(of), HERTZ, forces=pressing(of, 0, axis), axis=1 - axis
    )
    sideways = TURN[0] * TURN[1] @ [one.admittance for one in each]
    np.testing.assert_allclose(across, sideways, rtol=1e-7)
    # The control: the number that a force along the axis alone meets is another loop.
    b = 1.0 / float(np.linalg.inv(TURN @ np.diag(EIGENVALUES) @ TURN.T)[axis, axis])
    alone = transparency(linear_loops.scenario(master__impedance=b, **values), HERTZ)
    assert np.abs(alone.admittance / expected - 1.0).max() > 0.02


def test_users_with_other_matrices_at_their_ends_keep_the_object_in_balance():
    scenario = coupled(user1__server__impedance_matrix=OTHER, server__object_damping=0.0)
    forces = pressing(scenario, 0, 1)
    assert forces[0].tolist() == [0.0, 1.0]
    assert np.abs(forces[1]).min() > 0.05  # the transformer turns the force
    assert transparency(scenario, HERTZ, axis=1).rendered.admittance_dc is not None
    model = linearize.build(scenario)
    straight = np.array([[0.0, 1.0], [0.0, -1.0]])  # the control: not turned, all drift away
    low = [1e-3, 2e-3]
    drift, stays = (
        np.abs(frequency.response(model, np.array(low), forces=f, axis=1))
        for f in (straight, forces)
    )
    assert drift[0] / drift[1] > 1.9
    assert stays[0] / stays[1] == pytest.approx(1.0, abs=1e-3)


def test_a_matrix_is_predicted_by_its_own_model():
    values = {"link__delay_s": 0.008}
    scenario = coupled(**values)
    alone = [linear_loops.scenario(master__impedance=b, **values) for b in EIGENVALUES]
    found, *each = (prediction(one, live=False) for one in (scenario, *alone))
    largest = max(one["spectral_radius"] for one in each)
    assert found["spectral_radius"] == pytest.approx(largest, abs=1e-9)
    assert found["stable"] is True
    limit, *limits = (k_max(one).first or np.inf for one in (scenario, *alone))
    assert limit == pytest.approx(min(limits), rel=1e-3)


def test_a_late_coupling_is_not_proved_for_a_matrix():
    late = any_delay(coupled(server__coupling="one_frame_late"))
    assert not late.proved and late.gain > 1.05
    assert late.reasons[0].startswith("the gain around the loop is up to 1 + 0.09")
