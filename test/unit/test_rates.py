# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Holds: zero order and delayed first order."""

import numpy as np
import pytest

from pmwvc_core.wave.rates import Hold


def ticks_of(hold, packets, ticks):
    out = []
    for v in packets:
        hold.load(v)
        out += [hold.step() for _ in range(ticks)]
    return out


def test_a_zero_order_hold_repeats_the_packet():
    assert ticks_of(Hold("zoh", ticks=3), [1.0, -2.0], 3) == [1.0] * 3 + [-2.0] * 3


def test_a_first_order_hold_goes_from_the_packet_before_to_this_one():
    out = ticks_of(Hold("foh", ticks=4), [1.0, 3.0], 4)
    assert out == [0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0]


def test_a_first_order_hold_over_one_tick_is_a_zero_order_hold():
    packets = [1.0, -2.0, 0.5]
    assert ticks_of(Hold("foh", ticks=1), packets, 1) == packets


@pytest.mark.parametrize("kind", ["zoh", "foh"])
def test_before_the_first_packet_there_is_no_wave(kind):
    assert Hold(kind, ticks=8).step() == 0.0


@pytest.mark.parametrize("kind", ["zoh", "foh"])
def test_a_late_packet_leaves_the_last_one_standing(kind):
    hold = Hold(kind, ticks=4)
    hold.load(2.0)
    assert [hold.step() for _ in range(10)][3:] == [2.0] * 7


def test_an_early_packet_starts_its_ramp_where_the_last_one_got_to():
    hold = Hold("foh", ticks=4)
    hold.load(4.0)
    assert hold.step() == 1.0
    hold.load(5.0)
    assert [hold.step() for _ in range(4)] == [2.0, 3.0, 4.0, 5.0]


@pytest.mark.parametrize("kind", ["zoh", "foh"])
def test_runs_and_axes_side_by_side_equal_single_ones(kind):
    packets = np.random.default_rng(2).normal(size=(5, 4, 3))
    together = np.array(ticks_of(Hold(kind, ticks=8), packets, 8))
    for run in range(4):
        for axis in range(3):
            single = ticks_of(Hold(kind, ticks=8), packets[:, run, axis].tolist(), 8)
            assert together[:, run, axis].tolist() == single


def test_another_kind_is_refused_by_name():
    with pytest.raises(ValueError, match="hold = 'spline': must be one of zoh, foh"):
        Hold("spline", ticks=8)
