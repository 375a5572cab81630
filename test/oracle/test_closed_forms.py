# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The channel against numbers that were derived on paper or by another program."""

import platform

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal
from support.filter_runs import Stage
from support.strategies import TICK_S, amplitudes, poles_rad_s, power, signals

from pmwvc_core.law.wave.filter_and_hold import Hold, hold, load
from pmwvc_core.law.wave.wave import impedance, wave_force, wave_j, wave_u, wave_v, wave_velocity
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.aliasing import worst_case_gain
from pmwvc_core.wave.filter_design import design, half_power_hz

# Fused multiply-add, where a compiler uses it, rounds once instead of twice.
ROUNDING = 0.0 if platform.machine() in ("x86_64", "AMD64") else 1e-13


# --- encode and decode, b = 25 N s/m --------------------------------------------------------


@pytest.mark.parametrize(
    "f, xd, u, v", [(1.0, 0.1, 0.49497475, 0.21213203), (0.0, 1.0, 3.5355339, 3.5355339)]
)
def test_force_and_velocity_become_the_waves_of_the_worked_example(f, xd, u, v):
    b = impedance(25.0)
    assert wave_u(b, (xd,), (v,)) == pytest.approx((u,), abs=1e-7)
    assert wave_force(b, (xd,), (v,)) == pytest.approx((f,), abs=1e-6)
    assert wave_v(b, (u,), (f,)) == pytest.approx((v,), abs=1e-7)
    assert wave_velocity(b, (u,), (f,)) == pytest.approx((xd,), abs=1e-8)
    assert power(u, v) == pytest.approx(f * xd, abs=1e-6)


# --- anti-aliasing: gains, frequencies, arithmetic ------------------------------------------


@pytest.mark.parametrize(
    "pole, rate_drop, gain",
    [(50.0, 8, 1.01309), (100.0, 8, 1.0519), (-np.log(0.95) / TICK_S, 20, 1.0860)],
)
def test_worst_case_energy_gain_of_the_first_order_filters(pole, rate_drop, gain):
    found = worst_case_gain(
        FilterParams(kind="first_order", pole_rad_s=pole), tick_s=TICK_S, rate_drop=rate_drop
    )
    assert found == pytest.approx(gain, abs=5e-5)


@pytest.mark.parametrize("meet, hz", [("pass", 14.096), ("stop", 15.930)])
def test_half_power_frequency_of_the_butterworth_of_appendix_a(meet, hz):
    params = FilterParams(
        kind="butterworth", pass_hz=25.0, pass_db=20.0, stop_hz=50.0, stop_db=40.0, meet=meet
    )
    assert half_power_hz(params, tick_s=TICK_S) == pytest.approx(hz, abs=5e-4)
    sos = design(params, tick_s=TICK_S)
    assert 2 * len(sos) == 4
    _, response = signal.sosfreqz(sos, [2.0 * np.pi * hz * TICK_S])
    assert abs(response[0]) ** 2 == pytest.approx(0.5, abs=5e-4)


FILTERS = st.one_of(
    poles_rad_s.map(lambda pole: FilterParams(kind="first_order", pole_rad_s=pole)),
    st.builds(
        FilterParams,
        kind=st.just("butterworth"),
        stop_hz=st.floats(30.0, 400.0),
        meet=st.sampled_from(["pass", "stop"]),
    ),
)


@given(params=FILTERS, u=signals(longest=40, dof=3))
def test_on_arrays_the_filter_is_sosfilt_bit_by_bit(params, u):
    stage = Stage(params, axes=3)
    ours = np.array([stage.step(row) for row in u])
    scipys = signal.sosfilt(design(params, tick_s=TICK_S), u, axis=0)
    np.testing.assert_allclose(ours, scipys, rtol=ROUNDING, atol=ROUNDING * np.abs(u).max())


# --- delayed first-order hold: App. B Eq. 43-54 ---------------------------------------------


REST = Hold((0.0,), (0.0,), (0.0,), 0)


def left_in_the_hold(packets, *, ticks, s=REST):
    """Return the energy of the packets that has not come out at the ticks [J], and the hold."""
    received_j = emitted_j = 0.0
    for v in packets:
        received_j += wave_j((v,), ticks * TICK_S)
        s = load(s, (v,))
        for _ in range(ticks):
            s, wave = hold(s, ticks)
            emitted_j += wave_j(wave, TICK_S)
    return received_j - emitted_j, s


@given(packets=st.lists(amplitudes, min_size=1, max_size=20), ticks=st.integers(1, 24))
def test_what_a_first_order_hold_keeps_is_its_closed_form(packets, ticks):
    m = ticks
    steps = np.diff([0.0, *packets])
    closed = TICK_S * (m - 1) / (12 * m) * ((m + 1) * np.sum(steps**2) + 3 * m * packets[-1] ** 2)
    scale = np.sum(np.square(packets)) * m * TICK_S
    kept, _ = left_in_the_hold(packets, ticks=m)
    assert kept == pytest.approx(closed, abs=1e-12 * scale)
    assert kept >= -1e-12 * scale


@pytest.mark.parametrize("m", [2, 8, 20])
def test_hold_that_starts_at_another_value_generates_energy(m):
    c = 0.7
    _, s = left_in_the_hold([c], ticks=m)
    closed = -(c**2) * TICK_S * (m - 1) * (2 * m - 1) / (12 * m)
    kept, _ = left_in_the_hold([0.0], ticks=m, s=s)
    assert kept == pytest.approx(closed, rel=1e-12)
