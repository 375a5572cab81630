# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""MuJoCo scenes along six axes: what turns with the hands, what a free finger does, energy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from support.scenes import BOX, loaded
from support.scenes import PERIOD_S as H

from pmwvc_core.errors import ParameterError

LEVER_M = 0.05
PAD = (
    '<body name="{name}" pos="{x} 0 0">'
    '<geom type="box" size="0.002 0.01 0.01" mass="0.001" condim="4"/></body>'
)


def scene(folder, *, dof=6, handles="left, right"):
    """Return a free box between two pads, far above a table, with both users there."""
    pads = PAD.format(name="left", x=-0.0321) + PAD.format(name="right", x=0.0321)
    text = BOX.format(gravity="0 0 0", mass=0.2, mu=1.0).replace("-0.0401", "-0.2")
    file = folder / "turn.xml"
    file.write_text(text.replace("</worldbody>", pads * bool(handles) + "</worldbody>"), "utf-8")
    made = loaded(file, dof=dof, handles=handles)
    for user, side in enumerate((-1, 1)):
        made.join(user, np.eye(dof)[0] * side * 0.0301)
    return made


def turn(made, name):
    """Return how far a body is turned, as a vector [rad]."""
    return Rotation.from_quat(made.poses[name][3:], scalar_first=True).as_rotvec()


def test_two_handles_turn_a_box_as_their_ports_do(tmp_path):
    """About the axis between them, at the rate drive/(b l)."""
    made, drive, b = scene(tmp_path), np.zeros((2, 6)), np.full(2, 20.0)
    drive[:, 0] = 5.0, -5.0
    for step in range(375):
        drive[:, 3] = 0.5 * (step >= 125)
        v = made.meet(drive, b, H)
    for name in ("box", "left", "right"):
        np.testing.assert_allclose(turn(made, name), [1.0, 0.0, 0.0], atol=0.02)
    np.testing.assert_allclose(v[:, 3] / LEVER_M, 0.5, rtol=0.02)
    assert made.position[3] / LEVER_M == pytest.approx(turn(made, "box")[0], abs=1e-6)


def test_a_free_finger_turns_as_its_port_alone(tmp_path):
    made = scene(tmp_path, handles="")
    made.join(0, np.array([-0.1, 0.0, 0.0, 0.02, 0.01, 0.0]))
    start = np.array([0.02, 0.01, 0.0]) / LEVER_M
    drive, b = np.zeros((2, 6)), np.array([20.0, 20.0])
    drive[0] = 0.1, 0.0, 0.2, 0.3, -0.2, 0.4
    for _ in range(50):
        v = made.meet(drive, b, H)
    np.testing.assert_allclose(v[0], drive[0] / 20.0, atol=1e-15)
    way = Rotation.from_rotvec(50 * H * drive[0, 3:] / 20.0 / LEVER_M)
    expected = (way * Rotation.from_rotvec(start)).as_rotvec()
    late = 1e-4 * np.linalg.norm(drive[0, 3:]) / 20.0 / LEVER_M  # by a tenth of a sub-step: a gram
    np.testing.assert_allclose(turn(made, "pmwvc_user1"), expected, atol=late)
    found = Rotation.from_quat(made.turned[0]).as_rotvec()
    np.testing.assert_allclose(found, expected, atol=late)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_six_axes_give_out_no_energy_but_a_trace(tmp_path_factory, seed):
    made, rng = scene(tmp_path_factory.mktemp("scene")), np.random.default_rng(seed)
    drive, b, given_j, moved_j = np.zeros((2, 6)), np.full(2, rng.choice([8.0, 25.0])), 0.0, 0.0
    for _ in range(250):
        drive = 0.95 * drive + 0.31 * rng.normal(0.0, 2.0, (2, 6))
        v = made.meet(drive, b, H)
        power = (drive - b[:, None] * v) * v
        given_j, moved_j = given_j + H * power.sum(), moved_j + H * np.abs(power).sum()
        assert given_j >= -1e-3 * moved_j


def test_other_numbers_of_axes_are_refused(tmp_path):
    with pytest.raises(ParameterError, match="dof = 2: a scene has 3 or 6 axes"):
        scene(tmp_path, dof=2)
