# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded forces and motions as hands: played tick by tick, held on to, per axis."""

import numpy as np
import pytest
from support.operators import HALF, TICK_S, device, forces, operator

from pmwvc_core.errors import RecordingError


def playing(tmp_path, kind, values, **params):
    np.save(tmp_path / "recorded.npy", values)
    options = {"file": str(tmp_path / "recorded.npy"), "columns": "0", "fade_s": 0.0}
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


def test_a_recorded_hand_from_a_real_teleoperator_stays_in_hand(recorded_data):
    hand = operator(
        "playback_motion",
        file=str(recorded_data / "tue_hand.csv"),
        rate_hz=2000.0,
        scale=0.075,
        grip_stiffness=1000.0,
    )
    moving = device(0.05, x=-HALF)
    path = []
    for _ in range(5000):
        path.append(moving.x)
        moving.step(hand.step(moving.x, moving.xd), 0.0)
    assert 0.010 < np.abs(np.array(path) + HALF).max() < 0.015


def test_a_recording_needs_one_column_or_one_per_axis(tmp_path):
    values = np.tile([1.0, 2.0], (10, 1))
    with pytest.raises(RecordingError, match="are 2 columns for 3 axes; give one column"):
        playing(tmp_path, "playback_force", values, columns="0,1", dof=3)
    made = playing(tmp_path, "playback_force", values, columns="0,1", dof=2)
    np.testing.assert_allclose(made.step(np.zeros(2), np.zeros(2)), [1.0, 2.0])
    made = playing(tmp_path, "playback_force", values, columns="1", dof=2)
    np.testing.assert_allclose(made.step(np.zeros(2), np.zeros(2)), [2.0, 0.0])
