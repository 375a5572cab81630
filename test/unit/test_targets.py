# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands that follow a record: forces and motions played tick by tick, targets each at its tick."""

import numpy as np
import pytest
from support.operators import HALF, TICK_S, device, forces, operator

from pmwvc_core.errors import RecordingError
from pmwvc_core.params import OperatorParams, TaskParams


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
    again = forces(playing(tmp_path, "playback_force", wanted), 120)
    np.testing.assert_allclose(again, np.resize(wanted, 120), atol=1e-12)
    once = forces(playing(tmp_path, "playback_force", wanted, repeat=False), 120)
    np.testing.assert_allclose(once, [*wanted, *np.zeros(70)], atol=1e-12)


def test_a_recorded_motion_pulls_the_handle_along(tmp_path):
    time_s = TICK_S * np.arange(2000)
    wanted = 0.02 * np.sin(2 * np.pi * time_s)
    hand, moving = playing(tmp_path, "playback_motion", wanted), device(0.1, x=-HALF)
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
