# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""MuJoCo scenes of tests: a box on a table, and a scene with users in it."""

from pathlib import Path

import numpy as np

from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.scenes.mujoco_scene import MujocoScene
from pmwvc_core.server.black_box import EnvironmentSetup

CONFIG = Path(__file__).resolve().parents[2] / "pmwvc_bringup/config/scenes"
PERIOD_S = 0.008
BOX = """<mujoco><option gravity="{gravity}"/><worldbody>
  <geom name="table" type="box" size="0.3 0.3 0.01" pos="0 0 -0.0401"/>
  <body name="box"><freejoint/>
    <geom name="box" type="box" size="0.03 0.03 0.03" mass="{mass}" friction="{mu} 0.005 0.0001"/>
  </body></worldbody></mujoco>"""


def written(folder, *, mass=0.2, mu=1.0, gravity="0 0 -9.81"):
    """Write a box on a table whose faces are 30 mm from the origin; return the file's name."""
    file = Path(folder) / "box.xml"
    file.write_text(BOX.format(mass=mass, mu=mu, gravity=gravity), "utf-8")
    return str(file)


def loaded(file, sides=(-1, 1), dof=3, impedances=None, **values):
    """Return the scene of a file for users on these sides, none of which has joined."""
    server = ServerParams(coupling="unknown", environment="mujoco", scene=str(file), **values)
    contacts = (ContactParams(),) * len(sides)
    return MujocoScene(
        EnvironmentSetup(dof, PERIOD_S, sides, server, contacts, None, impedances or ())
    )


def scene(file, users=2, **values):
    """Return a scene with all fingers at the faces of the box, sides by turns."""
    sides = tuple(-1 if user % 2 == 0 else 1 for user in range(users))
    made = loaded(file, sides, **values)
    for user, side in enumerate(sides):
        made.join(user, np.array([0.0301 * side, 0.012 * (user // 2), 0.0]))
    return made


def held(made, squeeze, seconds, *, b=8.0, rise_m=0.0, stiffness=300.0):
    """Press with a squeeze [N], springs upwards; return places of the fingers and of the box."""
    users, impedance = len(made.held), np.full(len(made.held), b)
    x, v = np.zeros((users, 3)), np.zeros((users, 3))
    places = []
    for step in range(round(seconds / PERIOD_S)):
        lift_m = rise_m * min(max(step * PERIOD_S - 1.0, 0.0), 1.0)
        wanted = np.array([0.0, 0.0, lift_m])
        push = stiffness * (wanted - x) - 5.0 * v
        push[:, 0] = [squeeze * (1 if user % 2 == 0 else -1) for user in range(users)]
        v = made.meet(push + b * v, impedance, PERIOD_S)
        x = x + PERIOD_S * v
        places.append((x.copy(), made.position.copy()))
    return places
