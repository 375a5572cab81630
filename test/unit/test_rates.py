# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Between the rates: holds of zero and first order; means over frames longer or shorter than M."""

import pytest

from pmwvc_core.law.wave.filter_and_hold import Hold, filter_sample, filter_step, hold, load
from pmwvc_core.made.waves import made_filter
from pmwvc_core.params import FilterParams

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
