# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What is shown of a MuJoCo scene: contacts that carry its bodies, poses on disk and in tables."""

from pathlib import Path

import numpy as np
import pytest
from support.scenes import held, scene, written

from pmwvc_analysis.export import tables
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_session
from pmwvc_bringup.scenarios import load
from pmwvc_core.simulation.session import simulate

G = 9.81


def test_contacts_are_those_that_carry_the_box(tmp_path):
    """Newton: at rest the contact forces on the box sum up to minus its weight; each finger pushes
    with what its user does, where its surface is.
    """
    made = scene(written(tmp_path, mass=0.2))
    held(made, 2.0, 2.0)
    names, rows = [*made.poses, "fixed"], np.reshape(made.contacts, (-1, 8))
    force, at = {}, {}
    for first, second, *vectors in rows:
        pair = names[int(first)], names[int(second)]
        sign, other = (1.0, pair[0]) if pair[1] == "box" else (-1.0, pair[1])
        assert "box" in pair
        force[other] = force.get(other, 0.0) + sign * np.array(vectors[3:])
        at[other] = vectors[:3]
    assert set(force) == {"fixed", "pmwvc_user1", "pmwvc_user2"}
    np.testing.assert_allclose(sum(force.values()), [0.0, 0.0, 0.2 * G], atol=1e-4)
    assert force["pmwvc_user1"][0] == pytest.approx(2.0, abs=1e-4)
    np.testing.assert_allclose(at["pmwvc_user2"], [0.03, 0.0, 0.0], atol=2e-4)
    sizes = np.linalg.norm(rows[:, 5:], axis=1)
    assert (np.diff(sizes) <= 1e-9).all()  # strongest first
    held(made, -2.0, 0.5)  # let go
    assert all(-1.0 in row[:2] for row in np.reshape(made.contacts, (-1, 8)))


def test_no_more_than_sixteen_contacts_are_shown(tmp_path):
    file = Path(written(tmp_path))
    bodies = "".join(
        f'<body pos="{0.07 * k - 0.2:g} 0.1 0"><freejoint/><geom type="box" size="0.03 0.03 0.03" '
        f'mass="{0.1 * k + 0.1:g}"/></body>' for k in range(6)
    )  # fmt: skip
    file.write_text(file.read_text("utf-8").replace("</worldbody>", f"{bodies}</worldbody>"))
    made = scene(file)
    held(made, 0.0, 0.5)
    rows = np.reshape(made.contacts, (-1, 8))
    assert made.data.ncon >= 28 and len(rows) == 16
    assert set(rows[:, 1]) == {3.0, 4.0, 5.0, 6.0}  # the heaviest boxes


def test_poses_of_all_bodies_are_recorded_and_exported(tmp_path):
    """A free box that turns: its pose is that of the scene, in traces, on disk and as a table."""
    text = """name: a
controller: pmwvc
users: 1
dof: 3
duration_s: 1.0
server: {coupling: unknown, environment: mujoco, scene: FILE}
"""
    file = Path(written(tmp_path))
    spun = "<freejoint/></body></worldbody>"
    body = f'<body name="top" pos="0 0 0.5"><geom size="0.02" mass="0.1"/>{spun}'
    file.write_text(file.read_text("utf-8").replace("</worldbody>", body), "utf-8")
    scenario = tmp_path / "a.yaml"
    scenario.write_text(text.replace("FILE", file.name), "utf-8")
    traces = simulate([load(str(scenario))])[0]
    poses = traces.server.poses
    assert set(poses) == {"box", "top", "pmwvc_user1"}
    fallen_m = 0.5 - poses["top"][-1, 2]
    assert fallen_m > 0.3
    np.testing.assert_allclose(np.linalg.norm(poses["top"][:, 3:], axis=1), 1.0, rtol=1e-9)
    np.testing.assert_allclose(poses["pmwvc_user1"][:, :3].shape, (len(traces.server.step), 3))
    assert (traces.server.contained == 0).all()
    traces.server.contained[50:] = 3
    record_traces(tmp_path / "session", traces, load(str(scenario)))
    again = read_session(tmp_path / "session").server
    assert all((again.poses[name] == rows).all() for name, rows in poses.items())
    assert len(traces.server.contacts) > 4 * 100  # four corners of the box
    np.testing.assert_allclose(again.contacts, traces.server.contacts, rtol=1e-6)
    assert (again.contained == traces.server.contained).all()
    assert again.replaced == (pytest.approx(again.time_s[50]), 3)
    found = {each.name: each for each in tables(traces)}
    touching = found["contacts"].columns
    assert set(touching["body"]) | set(touching["other"]) <= {*poses, "fixed"}
    assert touching["f"].shape == touching["x"].shape == (len(touching["time_s"]), 3)
    table = found["server"]
    assert table.columns["pose_top"].shape == (len(traces.server.step), 7)
