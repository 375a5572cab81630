# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Filter and rate drop together: gain, delay, warnings."""

import math

import numpy as np
import pytest
from hypothesis import given
from support.filter_runs import BUTTERWORTH, KINDS, run
from support.strategies import TICK_S, poles_rad_s

from pmwvc_core.params import FilterParams
from pmwvc_core.wave.aliasing import delay_of, warnings_of, worst_case_gain


@pytest.mark.parametrize("params", KINDS, ids=lambda p: p.kind)
def test_the_delay_is_how_far_a_ramp_comes_out_behind(params):
    ramp = np.arange(4000.0)
    ticks, packets = run(params, ramp.tolist())
    last = packets[-1] if params.kind == "integrate_and_dump" else ticks[3991]
    behind = 3991.0 - last
    assert delay_of(params, tick_s=TICK_S, rate_drop=8) == pytest.approx(behind * TICK_S, abs=1e-9)


@pytest.mark.parametrize("rate_drop", [1, 2, 8, 20])
@given(pole=poles_rad_s)
def test_the_first_order_worst_case_is_its_closed_form(rate_drop, pole):
    p = math.exp(-pole * TICK_S)
    p_m = p**rate_drop
    closed = rate_drop * (1 - p) / (1 + p) * (1 + p_m) / (1 - p_m)
    gain = worst_case_gain(
        FilterParams(kind="first_order", pole_rad_s=pole), tick_s=TICK_S, rate_drop=rate_drop
    )
    assert gain == pytest.approx(closed, rel=1e-9)


@pytest.mark.parametrize("params", [KINDS[1], BUTTERWORTH], ids=lambda p: p.kind)
@pytest.mark.parametrize("rate_drop", [3, 8, 20])
def test_the_worst_case_is_the_largest_singular_value_of_filter_and_drop(params, rate_drop):
    # Impulse responses to every tick before the last packet, one row per packet.
    ticks = 1200
    impulse = np.zeros(ticks)
    impulse[0] = 1.0
    h, _ = run(params, impulse.tolist())
    instants = np.arange(rate_drop - 1, ticks, rate_drop)
    rows = np.zeros((len(instants), ticks))
    for row, instant in enumerate(instants):
        rows[row, : instant + 1] = h[instant::-1]
    largest = rate_drop * np.linalg.norm(rows, 2) ** 2
    gain = worst_case_gain(params, tick_s=TICK_S, rate_drop=rate_drop)
    assert largest <= gain * (1.0 + 1e-12)
    assert largest == pytest.approx(gain, rel=5e-3)


def test_a_filter_edge_above_half_the_packet_rate_is_named_with_its_worst_case():
    (text,) = warnings_of(
        FilterParams(kind="first_order", cutoff_hz=62.6), tick_s=TICK_S, rate_drop=8
    )
    gain = worst_case_gain(
        FilterParams(kind="first_order", cutoff_hz=62.6), tick_s=TICK_S, rate_drop=8
    )
    assert "62.6 Hz (-3 dB)" in text
    assert "half the packet rate (62.5 Hz)" in text
    assert f"{gain:.4g} times the energy" in text
    assert (
        warnings_of(FilterParams(kind="first_order", cutoff_hz=62.4), tick_s=TICK_S, rate_drop=8)
        == []
    )


def test_no_filter_is_warned_of_unless_every_tick_is_sent():
    (text,) = warnings_of(FilterParams(kind="none"), tick_s=TICK_S, rate_drop=20)
    assert "there is no filter" in text and "20 times" in text
    assert warnings_of(FilterParams(kind="none"), tick_s=TICK_S, rate_drop=1) == []
    assert warnings_of(FilterParams(kind="integrate_and_dump"), tick_s=TICK_S, rate_drop=20) == []
