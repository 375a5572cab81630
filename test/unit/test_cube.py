# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The shared object under held forces and by the midpoint rule."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from pmwvc_core.server.cube import Cube

H = 0.008
masses = st.floats(0.01, 50.0)
dampings = st.one_of(st.just(0.0), st.floats(1e-9, 200.0))


@given(mass=masses, damping=dampings, force=st.floats(-20.0, 20.0), start=st.floats(-1.0, 1.0))
def test_a_held_force_moves_the_cube_as_the_matrix_exponential_gives(mass, damping, force, start):
    cube = Cube(mass, damping, period=H)
    cube.xd = start
    generator = np.zeros((3, 3))
    generator[0, 1], generator[1, 1], generator[1, 2] = 1.0, -damping / mass, 1.0 / mass
    x, xd, _ = expm(H * generator) @ [0.0, start, force]
    moved, _ = cube.push(force)
    assert moved == cube.x == pytest.approx(x, rel=1e-10, abs=1e-13)
    assert cube.xd == pytest.approx(xd, rel=1e-10, abs=1e-12)


@given(mass=masses, damping=dampings, force=st.floats(-20.0, 20.0), start=st.floats(-1.0, 1.0))
def test_the_ground_only_takes_energy(mass, damping, force, start):
    cube = Cube(mass, damping, period=H)
    cube.xd = start
    before = cube.kinetic
    moved, lost = cube.push(force)
    scale = before + cube.kinetic + abs(force * moved)
    assert lost >= -1e-13 * scale
    if damping == 0.0:
        assert lost == pytest.approx(0.0, abs=1e-13 * scale)


def test_without_force_a_free_cube_keeps_its_velocity():
    cube = Cube(2.0, 0.0, period=H)
    cube.xd = 0.3
    for _ in range(100):
        cube.push(0.0)
    assert cube.xd == 0.3
    assert cube.x == pytest.approx(0.24)


@given(mass=masses, damping=dampings, force=st.floats(-20.0, 20.0), start=st.floats(-1.0, 1.0))
def test_the_midpoint_step_balances_work_motion_and_ground(mass, damping, force, start):
    cube = Cube(mass, damping, period=H)
    cube.xd = start
    before = cube.kinetic
    velocity = start - cube.imbalance(start, force) * cube.mobility(0.0)
    missing = cube.imbalance(velocity, force)
    assert missing == pytest.approx(0.0, abs=1e-12 * (abs(force) + 2 * mass / H))
    lost = cube.drift(velocity)
    work = H * force * velocity
    scale = before + cube.kinetic + abs(work) + lost
    assert work == pytest.approx(cube.kinetic - before + lost, abs=1e-12 * scale)
    assert cube.x == H * velocity


def test_each_run_has_its_own_mass_and_ground():
    mass, damping = np.array([[1.0], [4.0]]), np.array([[0.0], [3.0]])
    cube = Cube(mass, damping, period=H)
    moved, lost = cube.push(np.array([[1.0, 2.0], [1.0, 2.0]]))
    for run in range(2):
        single = Cube(float(mass[run, 0]), float(damping[run, 0]), period=H)
        moved_1, lost_1 = single.push(np.array([1.0, 2.0]))
        np.testing.assert_allclose(moved[run], moved_1, rtol=1e-14)
        np.testing.assert_allclose(lost[run], lost_1, rtol=1e-9, atol=1e-18)
