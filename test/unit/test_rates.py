# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Between the rates: holds, means over frames, and the energy of a rate drop (App. A and B)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.strategies import TICK_S

from pmwvc_core.law.wave.filter_and_hold import Hold, filter_sample, filter_step, hold, load
from pmwvc_core.made.waves import made_filter
from pmwvc_core.params import FilterParams
from reproduction import channel_energy


@given(edge=st.floats(1.6, 3.14))
def test_a_wave_with_images_gives_out_energy_and_one_tick_later_takes_it_in(edge):
    for shift in (0, 1):
        found = channel_energy.aliasing_example(edge, shift=shift, ticks=20_000)
        for name in ("in_j", "out_j", "left_j"):
            assert found[name] == pytest.approx(found[f"closed_{name}"], abs=2e-8)
    assert found["closed_left_j"] > 0.0
    assert channel_energy.aliasing_example(edge, ticks=2)["closed_left_j"] == pytest.approx(
        -found["closed_left_j"]
    )


def test_the_published_numbers_are_twice_the_energies():
    edge, alpha = 2.0, 3.0
    found = channel_energy.aliasing_example(edge, height=alpha, tick_s=TICK_S)
    printed = -TICK_S * alpha**2 * (2 * edge - np.pi) / np.pi  # App. A Eq. 18
    assert 2.0 * found["left_j"] == pytest.approx(printed, rel=1e-4)


@pytest.mark.parametrize(("hz", "lowest_j"), [(5.0, -0.0095), (24.0, -0.046), (24.9, -0.40)])
def test_a_sine_below_half_the_packet_rate_still_gets_below_zero_on_the_way(hz, lowest_j):
    angles = 2.0 * np.pi * hz * TICK_S * np.arange(20_000)
    waves = [np.sin(angles + phase) for phase in np.linspace(0.0, np.pi, 91)]
    found = [channel_energy.rate_drop_energy(u, rate_drop=20, tick_s=TICK_S) for u in waves]
    assert min(one["left_j"].min() for one in found) == pytest.approx(lowest_j, rel=0.02)


REST = Hold((0.0,), (0.0,), (0.0,), 0)


def ticks_of(packets, ticks, ramp, s=REST):
    out = []
    for v in packets:
        s = load(s, (v,))
        for _ in range(ticks):
            s, (value,) = hold(s, ramp)
            out.append(value)
    return out


@pytest.mark.parametrize("ramp", [1, 8])
def test_before_the_first_packet_there_is_no_wave(ramp):
    assert hold(REST, ramp)[1] == (0.0,)


@pytest.mark.parametrize("ramp", [1, 4])
def test_a_late_packet_leaves_the_last_one_standing(ramp):
    assert ticks_of([2.0], 10, ramp)[3:] == [2.0] * 7


def test_an_early_packet_starts_its_ramp_where_the_last_one_got_to():
    s, (first,) = hold(load(REST, (4.0,)), 4)
    assert first == 1.0
    assert ticks_of([5.0], 4, 4, s) == [2.0, 3.0, 4.0, 5.0]


@pytest.mark.parametrize(("ticks", "sent"), [(6, 6 / 8), (8, 1.0), (9, 1.0), (13, 1.0)])
def test_a_frame_is_divided_by_m_or_by_its_own_ticks_if_it_has_more(ticks, sent):
    params = FilterParams(kind="integrate_and_dump")
    s, p = made_filter(params, 1, 0.001, 8)
    for _ in range(2):  # the second frame knows nothing of the first
        for _ in range(ticks):
            s, _ = filter_step(s, (1.0,), p)
        s, wave = filter_sample(s, p)
        assert wave == pytest.approx((sent,), rel=1e-15)
        assert wave[0] ** 2 * max(8, ticks) <= ticks + 1e-12  # Cauchy-Schwarz
