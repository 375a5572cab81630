# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The task: smooth, periodic, and where it says it is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_core.params import TaskParams
from pmwvc_core.plant.forces import closing, minimum_jerk, offset, task_of

STEP_S = 1e-6
tasks = st.builds(
    TaskParams,
    kind=st.just("carry"),
    move_s=st.floats(0.0, 5.0),
    distance_m=st.floats(-0.2, 0.2),
    move_rise_s=st.floats(0.1, 5.0),
    rest_s=st.floats(0.0, 5.0),
    grip_s=st.floats(0.0, 5.0),
    grip_rise_s=st.floats(0.1, 5.0),
)


def test_a_minimum_jerk_move_begins_and_ends_at_rest_and_is_fastest_half_way():
    assert minimum_jerk(-1.0) == minimum_jerk(0.0) == 0.0
    assert minimum_jerk(1.0) == minimum_jerk(2.0) == 1.0
    assert minimum_jerk(0.5) == pytest.approx(0.5)
    slope = [_slope(minimum_jerk, progress) for progress in (0.0, 0.5, 1.0)]
    assert slope == pytest.approx([0.0, 1.875, 0.0], abs=1e-5)


def _slope(value, at):
    return (value(at + STEP_S) - value(at - STEP_S)) / (2.0 * STEP_S)


def test_carrying_goes_there_and_back_with_pauses():
    params = TaskParams(kind="carry", move_s=4.0, distance_m=0.05, move_rise_s=3.0, rest_s=1.0)
    task = task_of(params, 1)
    at = {0.0: 0.0, 4.0: 0.0, 5.5: 0.025, 7.0: 0.05, 7.9: 0.05, 9.5: 0.025, 11.0: 0.0, 15.0: 0.05}
    for time_s, place in at.items():
        assert offset(time_s, task)[0] == pytest.approx(place, abs=1e-12), time_s
    slopes = [_slope(lambda at: offset(at, task)[0], time_s) for time_s in (5.5, 9.5)]
    assert slopes == pytest.approx([0.05 * 1.875 / 3.0, -0.05 * 1.875 / 3.0])


@given(tasks, st.floats(0.0, 40.0))
def test_the_target_stays_on_its_way_and_hands_close_once(params, time_s):
    task = task_of(params, 1)
    low, high = sorted((0.0, params.distance_m))
    assert low - 1e-12 <= offset(time_s, task)[0] <= high + 1e-12
    closed = [closing(t, task) for t in np.linspace(0.0, time_s, 20)]
    assert all(0.0 <= share <= 1.0 for share in closed)
    assert closed == sorted(closed)


def test_in_several_axes_the_way_is_a_straight_line():
    params = TaskParams(kind="carry", distance_m=0.05, sideways_m=-0.02)
    for time_s in (0.0, 5.0, 6.3, 20.0):
        (along,) = offset(time_s, task_of(params, 1))
        np.testing.assert_allclose(offset(time_s, task_of(params, 3)), [along, -0.4 * along, 0.0])


@pytest.mark.parametrize(("kind", "closes"), [("free", 0.0), ("hold", 1.0), ("carry", 1.0)])
def test_only_carrying_moves_and_a_free_hand_does_not_close(kind, closes):
    task = task_of(TaskParams(kind=kind), 1)
    assert closing(100.0, task) == closes
    moved = any(offset(time_s, task)[0] for time_s in np.linspace(0.0, 30.0, 100))
    assert moved == (kind == "carry")
