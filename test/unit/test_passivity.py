# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Passivity over infinite time: folded gains."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.filter_runs import KINDS, run
from support.strategies import TICK_S, poles_rad_s

from pmwvc_core.params import FilterParams
from pmwvc_core.wave.aliasing import worst_case_gain
from pmwvc_core.wave.filter_design import response

TOLERANCE = 1e-12  # of a squared gain: what rounding may add to 1

FIRST_ORDER = FilterParams(kind="first_order", pole_rad_s=50.0)


def energy_gain(params, *, tick_s, rate_drop):
    """Return packet energy per energy of the wave over frequencies up to half the packet rate, and
    at worst: the folded gain sum_j |H(f + j/(M T_c))|^2 is that of a wave whose images all have
    the phase that adds up. Over infinite time (Parseval); at each instant more may be given out.
    """
    frame_s = rate_drop * tick_s
    frequency = np.linspace(0.0, 0.5 / frame_s, 513)
    images = np.add.outer(frequency, np.arange(rate_drop) / frame_s)
    values = response(params, images, tick_s=tick_s, rate_drop=rate_drop)
    gain = float(worst_case_gain(params, tick_s=tick_s, rate_drop=rate_drop))
    return {
        "folded": np.sum(np.abs(values) ** 2, axis=-1),
        "gain": gain,
        "passive": gain <= 1.0 + TOLERANCE,
    }


@pytest.mark.parametrize("params", KINDS, ids=lambda p: p.kind)
def test_no_packet_train_carries_more_than_the_gain(params):
    rng = np.random.default_rng(5)
    ratio = 8
    gain = energy_gain(params, tick_s=TICK_S, rate_drop=ratio)["gain"]
    # a signal that looks like the time-reversed response, the worst there is, and noise
    kernel = run(params, [1.0, *[0.0] * 399])[0][::-1]
    for wave in (rng.standard_normal(400), np.asarray(kernel)):
        _, packets = run(params, wave.tolist(), rate_drop=ratio)
        assert ratio * np.sum(np.square(packets)) <= gain * np.sum(np.square(wave)) * (1 + 1e-9)


@pytest.mark.parametrize("params", KINDS, ids=lambda p: p.kind)
def test_the_worst_gain_is_the_largest_of_the_fold(params):
    found = energy_gain(params, tick_s=TICK_S, rate_drop=8)
    assert found["folded"].max() == pytest.approx(found["gain"], rel=1e-6)


@given(pole=poles_rad_s, rate_drop=st.sampled_from([1, 2, 8, 20]))
def test_a_first_order_filter_before_a_rate_drop_is_never_strictly_passive(pole, rate_drop):
    p = math.exp(-pole * TICK_S)
    p_m = p**rate_drop
    closed = rate_drop * (1 - p) / (1 + p) * (1 + p_m) / (1 - p_m)
    found = energy_gain(
        FilterParams(kind="first_order", pole_rad_s=pole), tick_s=TICK_S, rate_drop=rate_drop
    )
    assert found["folded"][0] == pytest.approx(closed, rel=1e-9)
    assert found["passive"] is (closed <= 1.0 + TOLERANCE)


def test_the_mean_of_a_frame_is_passive_and_a_plain_rate_drop_is_not():
    mean, none = (
        energy_gain(FilterParams(kind=kind), tick_s=TICK_S, rate_drop=8)
        for kind in ("integrate_and_dump", "none")
    )
    assert mean["passive"]
    np.testing.assert_allclose(mean["folded"], 1.0, rtol=1e-12)
    assert not none["passive"]
    np.testing.assert_allclose(none["folded"], 8.0, rtol=1e-12)


@pytest.mark.parametrize("kind", ["none", "integrate_and_dump", "first_order"])
def test_the_response_is_that_of_the_running_filter(kind):
    params = FIRST_ORDER if kind == "first_order" else FilterParams(kind=kind)
    pulse = np.zeros(1024)
    pulse[0] = 1.0
    if kind == "integrate_and_dump":
        expected = np.fft.rfft(np.where(np.arange(1024) < 8, 1 / 8, 0.0))
    else:
        expected = np.fft.rfft(run(params, pulse.tolist())[0])
    frequency = np.fft.rfftfreq(1024, TICK_S)
    found = response(params, frequency, tick_s=TICK_S, rate_drop=8)
    np.testing.assert_allclose(found, expected, atol=1e-9)
