# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What users hold is the same whatever defaults a laboratory's file has for its own joints and
geoms: nothing of a file needs to be changed for it.
"""

import functools

import numpy as np
import pytest
from support.scenes import PERIOD_S as H
from support.scenes import loaded

SCENE = (
    '<mujoco>{}<option gravity="0 0 0"/><worldbody><body name="box"><freejoint/>'
    '<geom type="box" size=".03 .03 .03" mass="0.2" contype="1" conaffinity="1" margin="0" '
    'gap="0" group="{}" priority="0" friction="1 0.005 0.0001" pos="0 0 0" condim="3" solmix="1" '
    'solref="0.02 1"/></body></worldbody></mujoco>'
)
JOINTS = (
    'damping="50" armature="1" stiffness="100" frictionloss="1"',
    'limited="true" range="0.01 0.02"',
    'ref="0.5" springref="1" axis="0 1 0" pos="0.1 0 0"',
)
GEOMS = (
    'contype="0" conaffinity="0"',
    'margin="0.005" gap="0.001" priority="3" friction="0.5" pos="0.1 0 0"',
    'group="4" condim="1" solmix="0.1" solref="0.5 1"',
)
HEADS = [
    *(f"<default><joint {each}/></default>" for each in JOINTS),
    *(f"<default><geom {each}/></default>" for each in GEOMS),
    '<compiler inertiafromgeom="true" inertiagrouprange="3 4"/>',
]


@functools.cache
def pushed(folder, head, dof):
    """Return velocities of a finger that crosses the air and pushes a box, and its drawn geom."""
    file = folder / f"{abs(hash(head))}.xml"
    file.write_text(SCENE.format(head, 3 * ("inertiagroup" in head)), "utf-8")
    made = loaded(file, (-1,), dof)
    made.join(0, -0.04 * np.eye(dof)[0])
    drive, found = np.eye(dof)[[0]], []
    for _ in range(60):
        found.append((made.meet(drive, np.full(1, 9.0), H)[0], made.velocity.copy()))
    assert made.velocity[0] > 0.05  # pushed, and with a box of 0.2 kg
    return np.array(found), [each["user"] for each in made.description["shapes"]]


@pytest.mark.parametrize("dof", [3, 6])
@pytest.mark.parametrize("head", HEADS)
def test_a_finger_has_nothing_of_the_files_defaults(tmp_path_factory, head, dof):
    folder = tmp_path_factory.mktemp("scene")
    wanted, _ = pushed(folder, "", dof)
    found, users = pushed(folder, head, dof)
    np.testing.assert_allclose(found, wanted, atol=1e-9)
    assert 0 in users  # the finger is drawn
