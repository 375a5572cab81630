# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The arrival of a packet as a used wave shows it."""

import numpy as np
import pytest

from pmwvc_analysis.replay.arrivals import Looks, Sent, bounds

MS = 1_000_000


def column(*values):
    return np.array(values, dtype=float)[:, np.newaxis]


def times(*values):
    return np.array(values, dtype=np.int64) * MS


@pytest.fixture
def sent():
    return Sent(times(0, 8, 16, 24), column(0.0, 1.0, 2.0, 3.0))


def test_a_packet_that_was_used_had_come_and_newer_ones_had_not(sent):
    found = bounds(sent, Looks(times(10, 18, 26, 34), column(0.0, 1.0, 2.0, 3.0)))
    assert found.until_ns[1:].tolist() == [18 * MS, 26 * MS, 34 * MS]
    assert found.after_ns.tolist() == [-1, -1, 18 * MS, 26 * MS]


@pytest.mark.parametrize(
    ("arrival", "moved"), [(17.9, 18.000001), (20, 20), (26.0, 26), (26.1, 26)]
)
def test_an_arrival_that_does_not_fit_is_moved_just_so_far(sent, arrival, moved):
    found = bounds(sent, Looks(times(10, 18, 26, 34), column(0.0, 1.0, 2.0, 3.0)))
    assert found.moved(3, round(arrival * MS)) == pytest.approx(moved * MS, abs=1)


def test_a_wave_that_is_held_puts_the_next_packet_later(sent):
    found = bounds(sent, Looks(times(10, 18, 26, 34), column(0.0, 1.0, 1.0, 3.0)))
    assert found.after_ns[2] == 26 * MS
    assert found.until_ns[3] == 34 * MS


def test_waves_of_zero_and_equal_waves_tell_nothing():
    sent = Sent(times(0, 8, 16), column(0.0, 1.0, 1.0))
    found = bounds(sent, Looks(times(10, 18), column(0.0, 1.0)))
    assert found.after_ns.tolist() == [-1, -1, -1]
    assert (found.until_ns > 10**15).all()


def test_wave_without_a_sender_bounds_nothing(sent):
    found = bounds(sent, Looks(times(10, 18), column(0.5, 0.7)))
    assert found.after_ns.tolist() == [-1] * 4
