# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The anti-aliasing filter: its cut-off and its output."""

import math

import numpy as np
import pytest
from hypothesis import given
from scipy import signal
from support.filter_runs import BUTTERWORTH, KINDS, Stage, run
from support.strategies import TICK_S, poles_rad_s, signals

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.filter_design import design, half_power_hz, pole_of


def gain_at(sos, hz):
    return abs(signal.sosfreqz(sos, [2.0 * math.pi * hz * TICK_S])[1][0])


def test_without_a_cut_off_the_pole_is_that_of_appendix_b():
    assert pole_of(FilterParams(kind="first_order")) == 50.0


def test_the_three_conventions_name_the_same_filter():
    pole = 70.0
    at_minus_3_db = pole / (2.0 * math.pi)
    at_minus_20_db = at_minus_3_db * math.sqrt(99.0)
    assert pole_of(FilterParams(kind="first_order", pole_rad_s=pole)) == pole
    assert pole_of(FilterParams(kind="first_order", cutoff_hz=at_minus_3_db)) == pytest.approx(
        pole
    )
    assert pole_of(FilterParams(kind="first_order", stop_hz=at_minus_20_db)) == pytest.approx(pole)
    for hz, db in ((at_minus_3_db, 10 * math.log10(2)), (at_minus_20_db, 20.0)):
        s = 2j * math.pi * hz
        assert -20 * math.log10(abs(pole / (s + pole))) == pytest.approx(db)


def test_the_first_order_filter_is_exact_under_a_held_input():
    # Step response of a/(s+a) at the ticks: 1 - exp(-a t).
    stage = Stage(FilterParams(kind="first_order", pole_rad_s=50.0))
    for k in range(1, 100):
        assert stage.step(1.0) == pytest.approx(1.0 - math.exp(-50.0 * k * TICK_S))


@pytest.mark.parametrize("meet, hz, db", [("pass", 25.0, 20.0), ("stop", 50.0, 40.0)])
def test_a_bilinear_butterworth_meets_its_edge_exactly(meet, hz, db):
    sos = design(
        FilterParams(kind="butterworth", pass_hz=25.0, stop_hz=50.0, meet=meet), tick_s=TICK_S
    )
    assert len(sos) == 2  # order 4
    assert -20.0 * math.log10(gain_at(sos, hz)) == pytest.approx(db, abs=1e-9)


@pytest.mark.parametrize("meet", ["pass", "stop"])
@pytest.mark.parametrize("discretisation", ["bilinear", "matched"])
def test_a_butterworth_keeps_both_attenuations(meet, discretisation):
    params = FilterParams(
        kind="butterworth", stop_hz=50.0, meet=meet, discretisation=discretisation
    )
    sos = design(params, tick_s=TICK_S)
    loss = [-20.0 * math.log10(gain_at(sos, hz)) for hz in (0.0, 25.0, 50.0)]
    slack = 0.5 if discretisation == "matched" else 1e-9  # its edges are those of the analogue
    assert loss[0] == pytest.approx(0.0, abs=1e-9)
    assert loss[1] <= 20.0 + slack
    assert loss[2] >= 40.0 - slack


def test_the_half_power_frequency_of_a_butterworth_has_half_the_power():
    for meet in ("pass", "stop"):
        params = FilterParams(kind="butterworth", stop_hz=50.0, meet=meet)
        edge = half_power_hz(params, tick_s=TICK_S)
        assert gain_at(design(params, tick_s=TICK_S), edge) ** 2 == pytest.approx(0.5)


def test_a_stop_edge_above_half_the_tick_rate_does_not_hinder_meeting_the_pass_edge():
    params = FilterParams(
        kind="butterworth", pass_hz=200.0, pass_db=1.0, stop_hz=600.0, stop_db=40.0
    )
    sos = design(params, tick_s=TICK_S)
    assert -20.0 * math.log10(gain_at(sos, 200.0)) == pytest.approx(1.0, abs=1e-9)


def test_an_edge_above_half_the_tick_rate_cannot_be_met_by_a_bilinear_filter():
    params = FilterParams(kind="butterworth", pass_hz=200.0, stop_hz=600.0, meet="stop")
    with pytest.raises(ParameterError, match=r"stop_hz = 600.*must be < 500 Hz.*use matched"):
        design(params, tick_s=TICK_S)


def test_edges_too_close_together_are_refused():
    params = FilterParams(kind="butterworth", pass_hz=49.9, stop_hz=50.0)
    with pytest.raises(ParameterError, match=r"of order \d+, more than 20; move the edges apart"):
        design(params, tick_s=TICK_S)


@pytest.mark.parametrize("params", KINDS, ids=lambda p: p.kind)
def test_a_constant_wave_passes_unchanged(params):
    _, packets = run(params, [0.7] * 4000)
    assert packets[-1] == pytest.approx(0.7, rel=1e-9)


@pytest.mark.parametrize("params", KINDS, ids=lambda p: p.kind)
def test_the_first_packet_is_zero(params):
    _, packets = run(params, [1.0])
    assert packets == [0.0]


@pytest.mark.parametrize("params", KINDS[:3], ids=lambda p: p.kind)
def test_a_packet_is_the_output_after_the_last_tick(params):
    ticks, packets = run(params, np.random.default_rng(3).normal(size=80).tolist())
    assert packets[1:] == ticks[7:79:8]


def test_integrate_and_dump_sends_the_mean_of_the_frame():
    u = np.random.default_rng(4).normal(size=81)
    _, packets = run(FilterParams(kind="integrate_and_dump"), u.tolist())
    np.testing.assert_allclose(packets[1:], u[:80].reshape(10, 8).mean(axis=1), rtol=1e-12)


def test_integrate_and_dump_keeps_the_integral_when_ticks_are_missing():
    stage = Stage(FilterParams(kind="integrate_and_dump"))
    for value in (1.0, 2.0, 3.0):
        stage.step(value)
    assert stage.sample() * 8 == pytest.approx(6.0)
    assert stage.sample() == 0.0


@given(u=signals(dof=2), pole=poles_rad_s)
def test_several_axes_are_several_filters(u, pole):
    for params in (FilterParams(kind="first_order", pole_rad_s=pole), BUTTERWORTH):
        together, _ = run(params, u)
        for axis in range(2):
            single, _ = run(params, u[:, axis].tolist())
            assert [row[axis] for row in together] == single
