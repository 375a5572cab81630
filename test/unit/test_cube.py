# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The shared object under held forces and by the midpoint rule."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from pmwvc_core.law.motion import (
    Body,
    body_law,
    drifted,
    imbalance,
    kinetic_j,
    mobility,
    pushed_body,
)

H = 0.008
masses = st.floats(0.01, 50.0)
dampings = st.one_of(st.just(0.0), st.floats(1e-9, 200.0))


@given(mass=masses, damping=dampings, force=st.floats(-20.0, 20.0), start=st.floats(-1.0, 1.0))
def test_a_held_force_moves_the_cube_as_the_matrix_exponential_gives(mass, damping, force, start):
    """The ground takes energy only, without damping none."""
    law, before = body_law(mass, damping, H), Body((0.0,), (start,))
    generator = np.zeros((3, 3))
    generator[0, 1], generator[1, 1], generator[1, 2] = 1.0, -damping / mass, 1.0 / mass
    x, xd, _ = expm(H * generator) @ [0.0, start, force]
    after, (moved,), lost_j = pushed_body(before, (force,), law)
    assert moved == after.x[0] == pytest.approx(x, rel=1e-10, abs=1e-13)
    assert after.xd[0] == pytest.approx(xd, rel=1e-10, abs=1e-12)
    scale = kinetic_j(before, law) + kinetic_j(after, law) + abs(force * moved)
    assert lost_j >= -1e-13 * scale
    if damping == 0.0:
        assert lost_j == pytest.approx(0.0, abs=1e-13 * scale)


@given(mass=masses, damping=dampings, force=st.floats(-20.0, 20.0), start=st.floats(-1.0, 1.0))
def test_the_midpoint_step_balances_work_motion_and_ground(mass, damping, force, start):
    law, before = body_law(mass, damping, H), Body((0.0,), (start,))
    velocity = start - imbalance(start, start, force, law) * mobility(0.0, law)
    missing = imbalance(start, velocity, force, law)
    assert missing == pytest.approx(0.0, abs=1e-12 * (abs(force) + 2 * mass / H))
    after, lost_j = drifted(before, (velocity,), law)
    work, gained_j = H * force * velocity, kinetic_j(after, law) - kinetic_j(before, law)
    scale = kinetic_j(before, law) + kinetic_j(after, law) + abs(work) + lost_j
    assert work == pytest.approx(gained_j + lost_j, abs=1e-12 * scale)
    assert after.x == (H * velocity,)


def test_a_wall_does_not_give_way():
    wall, law = Body((0.0,), (0.0,)), body_law(float("inf"), 0.0, H)
    assert pushed_body(wall, (1e3,), law) == (wall, (0.0,), 0.0)
    assert drifted(wall, (0.0,), law) == (wall, 0.0)
    assert (mobility(3.0, law), kinetic_j(wall, law)) == (0.0, 0.0)
