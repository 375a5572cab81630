# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The wave transformation at both ports: App. B Fig. 1."""

import numpy as np
import pytest
from hypothesis import given
from support.strategies import amplitudes, impedances
from support.wave_power import power

from pmwvc_core.numeric import squared
from pmwvc_core.wave.impedance import WavePort

LAWS = (WavePort.u, WavePort.force, WavePort.v, WavePort.velocity)


@given(xd=amplitudes, v=amplitudes, b=impedances)
def test_the_master_port_carries_the_power_of_force_and_velocity(xd, v, b):
    u, f = WavePort(b).u(xd, v), WavePort(b).force(xd, v)
    scale = u * u + v * v
    assert power(u, v) == pytest.approx(f * xd, abs=1e-12 * scale)


@given(u=amplitudes, f=amplitudes, b=impedances)
def test_the_server_port_carries_the_power_of_force_and_velocity(u, f, b):
    v, xd = WavePort(b).v(u, f), WavePort(b).velocity(u, f)
    scale = u * u + v * v
    assert power(u, v) == pytest.approx(f * xd, abs=1e-12 * scale)


@given(xd=amplitudes, v=amplitudes, b=impedances)
def test_a_server_that_answers_with_the_master_force_moves_with_the_master(xd, v, b):
    u, f = WavePort(b).u(xd, v), WavePort(b).force(xd, v)
    assert WavePort(b).velocity(u, f) == pytest.approx(xd, rel=1e-9, abs=1e-9 * abs(u))
    assert WavePort(b).v(u, f) == pytest.approx(v, rel=1e-9, abs=1e-9 * abs(u))


@given(xd=amplitudes, f=amplitudes, b_m=impedances, b_s=impedances)
def test_different_impedances_are_a_lossless_transformer(xd, f, b_m, b_s):
    # The server's force and velocity make the wave pair; the master reads it with its own b.
    u = (f + b_s * xd) / np.sqrt(2.0 * b_s)
    v = WavePort(b_s).v(u, f)
    ratio = np.sqrt(b_s / b_m)
    xd_m = (u + v) / np.sqrt(2.0 * b_m)
    f_m = WavePort(b_m).force(xd_m, v)
    scale = abs(f * ratio) + abs(xd * b_s) + 1.0
    assert xd_m == pytest.approx(xd * ratio, rel=1e-6, abs=1e-9 * scale)
    assert f_m == pytest.approx(f / ratio, rel=1e-6, abs=1e-9 * scale * b_m)


def test_a_port_with_reversed_sign_does_not_carry_its_power():
    b, xd, v = 25.0, 0.1, 0.4
    f_wrong = b * xd + np.sqrt(2.0 * b) * v
    assert power(WavePort(b).u(xd, v), v) != pytest.approx(f_wrong * xd, rel=0.1)


def test_runs_and_axes_side_by_side_equal_single_ones():
    rng = np.random.default_rng(11)
    xd, v, b = rng.normal(size=(4, 3)), rng.normal(size=(4, 3)), rng.uniform(1, 50, size=(4, 1))
    for law in LAWS:
        together = law(WavePort(b), xd, v)
        for run in range(4):
            for axis in range(3):
                port = WavePort(float(b[run, 0]))
                single = law(port, float(xd[run, axis]), float(v[run, axis]))
                assert together[run, axis] == single


def test_the_squared_length_of_several_axes_is_one_number_per_run():
    np.testing.assert_allclose(squared(np.array([[3.0, 4.0], [0.0, 1.0]])), [[25.0], [1.0]])


def test_plain_floats_stay_plain_floats():
    for law in LAWS:
        assert type(law(WavePort(25.0), 0.1, 0.2)) is float
    assert type(squared(0.1)) is float
