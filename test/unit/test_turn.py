# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Orientations of a driver as the way of a handle that turns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pmwvc_master.devices.turn import Turn

LEVER_M = 0.05


@given(
    seed=st.integers(0, 2**32 - 1), size=st.floats(1e-9, 3.0), flips=st.booleans(),
)  # fmt: skip
def test_the_way_is_the_sum_of_the_turns_whatever_the_sign_of_a_quaternion(seed, size, flips):
    rng, turn = np.random.default_rng(seed), Turn(LEVER_M)
    q, way = Rotation.random(random_state=seed), np.zeros(3)
    assert turn.add(q.as_quat())
    for number in range(20):
        step = rng.normal(size=3)
        step *= size / np.linalg.norm(step)
        q, way = Rotation.from_rotvec(step) * q, way + LEVER_M * step
        assert turn.add(q.as_quat() * (-1.0 if flips and number % 2 else 1.0))
        np.testing.assert_allclose(turn.way, way, atol=1e-9)


MIRROR, LARGER = np.diag([1.0, 1.0, -1.0]).ravel(), 1.01 * np.eye(3).ravel()


@pytest.mark.parametrize("wrong", [
    [0.0] * 4, [0.0, 0.0, 0.0, 1.01], [np.nan, 0.0, 0.0, 1.0], [0.0] * 9, MIRROR, LARGER,
])  # fmt: skip
def test_what_is_no_unit_quaternion_and_no_rotation_is_not_taken(wrong):
    turn = Turn(LEVER_M)
    assert turn.add([0.0, 0.0, 0.0, 1.0])
    assert not turn.add(wrong)
    assert turn.add(Rotation.from_rotvec([0.0, 0.0, 0.1]).as_quat())
    np.testing.assert_allclose(turn.way, [0.0, 0.0, 0.1 * LEVER_M], atol=1e-12)
