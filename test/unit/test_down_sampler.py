# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy of the rate drop over the cut-off of the filter before it (App. A Fig. 8)."""

import numpy as np
import pytest

from pmwvc_core.params import FilterParams
from pmwvc_core.simulation.session import simulate_one
from reproduction import down_sampler

# App. A Table 2: edges of pass and stop band [Hz]; 20 and 40 dB.
EDGES_HZ = ((10.0, 25.0), (25.0, 50.0), (50.0, 100.0), (100.0, 150.0), (150.0, 200.0))
SHORT = {"duration_s": 3.0, "operator.frequency_hz": 2.0}


def table_filters():
    return [FilterParams(kind="butterworth", pass_hz=a, stop_hz=b) for a, b in EDGES_HZ]


def test_the_account_is_that_of_the_filtered_wave_and_its_samples():
    scenario = down_sampler.printed_scenario(**SHORT)
    params = table_filters()[1]
    found = down_sampler.energy_over_cut_off(scenario, [params])
    traces = simulate_one(down_sampler.with_filter(scenario, params))
    wave = traces.users[0].u_m_lp[:, 0]
    frames = wave.reshape(-1, 20)
    sent = np.concatenate([[0.0], frames[:-1, -1]])  # the output after the last tick
    kept = np.cumsum(np.sum(frames**2, axis=1)) - np.sum(frames**2, axis=1)
    expected = 0.5e-3 * (kept - 20 * np.cumsum(sent**2))
    np.testing.assert_allclose(found["left_j"][0], expected, atol=1e-15)
    assert found["minimum_j"][0] == pytest.approx(expected.min())
    assert found["final_j"][0] == pytest.approx(expected[-1])


def test_aliasing_with_a_late_computation_feeds_the_oscillation():
    """The passive server is the control: with its loop solved the same wave gives out little."""
    late = {"server.coupling": "one_step_delay", "server.integrator": "backward_euler"}
    _, narrow, _, wide, _ = table_filters()
    found = down_sampler.energy_over_cut_off(
        down_sampler.printed_scenario(**SHORT, **late), [narrow, wide]
    )
    assert found["minimum_j"][0] > -1e-3
    assert found["minimum_j"][1] < -0.02
    assert found["final_j"][1] < -0.02
    solved = down_sampler.energy_over_cut_off(down_sampler.printed_scenario(**SHORT), [wide])
    assert solved["minimum_j"][0] > -5e-3


def test_the_published_filters_are_those_of_the_table():
    filters = table_filters()
    assert [f.pass_hz for f in filters] == [10.0, 25.0, 50.0, 100.0, 150.0]
    assert all((f.pass_db, f.stop_db) == (20.0, 40.0) for f in filters)
