# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands that follow a record, forces and motions tick by tick, targets each at its tick; the task:
smooth, periodic, and where it says it is.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.operators import HALF, TICK_S, device, forces, operator

from pmwvc_core.errors import RecordingError
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.plant.forces import closing, minimum_jerk, offset, task_of


def remote(*, dof=1, task="free", **params):
    return operator("remote", task=task, start=-HALF - 0.01, dof=dof, **params)


def taken(hand, ticks):
    """The newest target by the tick at which it comes, None where it lets go."""
    found = {}
    for tick in range(ticks):
        hand.step(0.0, 0.0)
        newest = hand.remote
        if newest.age == 0:
            found[tick] = newest.wanted if newest.usable else None
    return found


def test_the_task_is_done_with_a_pointer_that_presses_once_it_has_closed():
    found = taken(remote(task="carry", squeeze=3.0), 1200)
    assert min(found) >= 100
    ticks = sorted(found)
    assert set(np.diff(ticks)) == {16}
    places = np.array([found[tick][0] for tick in ticks])
    assert places[0] == pytest.approx(-HALF - 0.01, abs=1e-3)
    inside = 3.0 / OperatorParams().remote.stiffness
    still = places[(np.array(ticks) > 300) & (np.array(ticks) < 500)]
    np.testing.assert_allclose(still, -HALF + inside, atol=1e-12)
    assert places[-1] == pytest.approx(-HALF + inside + TaskParams().distance_m, abs=1e-6)
    assert taken(remote(task="free"), 500) == {}


def test_time_before_coupling_does_not_count():
    hand = remote(task="hold")
    assert [hand.hold() for _ in range(500)] == [0.0] * 500
    assert min(taken(hand, 300)) >= 100


def playing(tmp_path, kind, values, **params):
    np.savetxt(tmp_path / "recorded.csv", values)
    options = {"file": str(tmp_path / "recorded.csv"), "columns": "0", "fade_s": 0.0}
    return operator(kind, **(options | params))


def test_a_recorded_force_is_played_tick_by_tick_again_or_once(tmp_path):
    wanted = np.sin(np.arange(50))
    again = forces(playing(tmp_path, "playback_force", wanted, repeat=True), 120)
    np.testing.assert_allclose(again, np.resize(wanted, 120), atol=1e-12)
    once = forces(playing(tmp_path, "playback_force", wanted), 120)
    np.testing.assert_allclose(once, [*wanted, *np.zeros(70)], atol=1e-12)


def test_a_recorded_motion_pulls_the_handle_along(tmp_path):
    time_s = TICK_S * np.arange(2000)
    wanted = 0.02 * np.sin(2 * np.pi * time_s)
    hand = playing(tmp_path, "playback_motion", wanted, repeat=True)
    moving = device(0.1, x=-HALF)
    path = []
    for _ in range(4000):
        path.append(moving.x)
        moving.step(hand.step(moving.x, moving.xd), 0.0)
    np.testing.assert_allclose(np.array(path[2000:]) + HALF, wanted, atol=5e-4)


def test_a_recorded_motion_that_ends_holds_on_where_it_ended(tmp_path):
    hand = playing(tmp_path, "playback_motion", np.linspace(0.0, 0.01, 100), repeat=False)
    moving = device(0.1, x=-HALF)
    for _ in range(3000):
        moving.step(hand.step(moving.x, moving.xd), 0.0)
    assert moving.x == pytest.approx(-HALF + 0.01, abs=1e-6)


def test_a_recording_needs_one_column_or_one_per_axis(tmp_path):
    values = np.tile([1.0, 2.0], (10, 1))
    with pytest.raises(RecordingError, match="are 2 columns for 3 axes; give one column"):
        playing(tmp_path, "playback_force", values, columns="0,1", dof=3)
    made = playing(tmp_path, "playback_force", values, columns="0,1", dof=2)
    np.testing.assert_allclose(made.step(np.zeros(2), np.zeros(2)), [1.0, 2.0])
    made = playing(tmp_path, "playback_force", values, columns="1", dof=2)
    np.testing.assert_allclose(made.step(np.zeros(2), np.zeros(2)), [2.0, 0.0])


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
