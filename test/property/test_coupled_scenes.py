# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes behind wave impedances that couple the axes of the world; a box: ``test_box.py``."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from property.test_box import H, box, matrix
from scipy.spatial.transform import Rotation
from support.scenes import loaded

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import ServerParams

LEVER_M = ServerParams().lever_m
PLANE = (
    '<mujoco><option gravity="0 0 0" timestep="0.001"/><worldbody>'
    '<geom type="plane" size="0 0 1" zaxis="{:.17g} {:.17g} {:.17g}" friction="0 0 0"/>'
    "</worldbody></mujoco>"
)

HANDLE = (
    '<mujoco><option gravity="0 0 0"/><worldbody><body name="grip" pos="0 0 1" quat="{}">'
    '<geom type="box" size="0.01 0.02 0.03" mass="0.1"/></body></worldbody></mujoco>'
)


def test_a_number_is_a_matrix_that_couples_nothing():
    alone, coupled = box(), box()
    for step in range(60):
        drive = np.array([[4.0, 0.3 * np.sin(0.1 * step), 0.0, 0.2, 0.0, 0.1]] * 2)
        drive[1, 0] *= -1.0
        v = alone.meet(drive, np.full(2, 9.0), H)
        w = coupled.meet(drive, np.array([9.0 * np.eye(6)] * 2), H)
        np.testing.assert_allclose(v, w, rtol=0.0, atol=1e-12)


def finger(folder, normal, b):
    """Return a scene of one finger on a smooth plane through the origin."""
    file = folder / "plane.xml"
    file.write_text(PLANE.format(*normal), "utf-8")
    made = loaded(file, (-1,), impedances=(b,))
    made.join(0, normal * 0.0102 + np.array([0.01, 0.0, 0.0]))
    return made


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_finger_slides_on_a_plane_as_its_matrix_has_it(tmp_path_factory, seed):
    """In the air v = B^-1 d; on a plane of normal n, v = B^-1 (d - N n) with n . v = 0."""
    rng = np.random.default_rng(seed)
    normal = Rotation.random(random_state=seed).as_matrix()[:, 2]
    b = matrix(rng, 3)
    made = finger(tmp_path_factory.mktemp("plane"), normal, b)
    push = rng.normal(0.0, 0.3, 3)
    for drive, slides in ((push + normal * (0.5 - push @ normal), False), (push, True)):
        if slides:
            drive = drive - normal * (drive @ normal + 3.0)
            along = np.linalg.solve(b, normal)
            drive = drive - normal * max((along @ drive) / (along @ normal) + 1.0, 0.0)
        for _ in range(150 if slides else 3):
            v = made.meet(drive[None], b[None], H)[0]
        pressing = slides * (along @ drive) / (along @ normal) if slides else 0.0
        expected = np.linalg.solve(b, drive - pressing * normal)
        np.testing.assert_allclose(v, expected, atol=2e-3 * np.linalg.norm(expected) + 1e-5)


def test_a_ball_joint_resists_alike_about_all_axes(tmp_path):
    file = tmp_path / "plane.xml"
    file.write_text(PLANE.format(0.0, 0.0, 1.0), "utf-8")
    b = matrix(np.random.default_rng(1), 6)
    with pytest.raises(ParameterError, match="axes 4 to 6 have one number"):
        loaded(file, (-1,), 6, (b,))


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), dof=st.sampled_from([3, 6]), couples=st.booleans())
def test_a_handle_moves_along_the_axes_of_the_world_however_the_file_has_turned_it(
    tmp_path_factory, seed, dof, couples
):
    rng, start = np.random.default_rng(seed), Rotation.random(random_state=seed)
    b = 15.0 * np.eye(dof)
    b[:3, :3] = matrix(rng, 3) if couples else b[:3, :3]
    file = tmp_path_factory.mktemp("handle") / "handle.xml"
    quat = " ".join(map(repr, start.as_quat(scalar_first=True).tolist()))
    file.write_text(HANDLE.format(quat), "utf-8")
    made = loaded(file, (-1,), dof, (b,), handles="grip")
    made.join(0, np.zeros(dof))
    before, drive = np.array(made.poses["grip"]), rng.normal(0.0, 0.3, dof)
    for _ in range(300):
        v = made.meet(drive[None], b[None], H)[0]
    expected = np.linalg.solve(b, drive)  # but for how its inertia turns
    np.testing.assert_allclose(v, expected, atol=5e-3 * np.linalg.norm(expected))
    moved = np.array(made.poses["grip"])
    way = moved[:3] - before[:3]
    np.testing.assert_allclose(way / np.linalg.norm(way), v[:3] / np.linalg.norm(v[:3]), atol=0.02)
    turn = (Rotation.from_quat(moved[3:], scalar_first=True) * start.inv()).as_rotvec()
    seen = (Rotation.from_quat(made.turned[0]) * start.inv()).as_rotvec()
    np.testing.assert_allclose(seen, turn, atol=1e-9)
    if dof == 6:
        along = v[3:] / np.linalg.norm(v[3:])
        rate = Rotation.from_rotvec(along * 300 * H * np.linalg.norm(v[3:]) / LEVER_M)
        assert (rate.inv() * Rotation.from_rotvec(turn)).magnitude() < 0.1
