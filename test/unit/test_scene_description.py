# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What is said of a scene: shapes and files, recorded, and enough to make the scene again."""

import json
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rclpy.serialization import serialize_message
from scipy.spatial.transform import Rotation
from std_msgs.msg import String
from support import rewriting
from support.lab import offer
from support.law_rigs import Users
from support.rewriting import raw
from support.scenes import CONFIG, scene

from pmwvc_analysis.export import export
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.replay.run import exact, replay
from pmwvc_analysis.replay.scene_files import as_described
from pmwvc_bringup.scenarios import load
from pmwvc_core.errors import ParameterError
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.server import environments
from pmwvc_core.server.black_box import description_of
from pmwvc_core.simulation.session import simulate

CORNERS = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
SCENE = """<mujoco><compiler meshdir="../meshes"/><include file="parts/defaults.xml"/>
<asset><texture name="wood" type="2d" file="wood.png"/>
<material name="red" texture="wood" rgba="1 0 0 1"/><mesh name="corner" file="corner.obj"/></asset>
<worldbody><geom type="plane" size="1 1 0.1" pos="0 0 -0.5" material="red"/>
<body name="post" pos="0.3 0 0" euler="0 0 90"><geom size="0.01" rgba="0 1 0 1"/></body>
<body pos="0 0 0.2"><freejoint/><geom type="mesh" mesh="corner"/>
<geom class="unseen" size="0.01" mass="0"/></body></worldbody></mujoco>"""


@pytest.fixture
def file(tmp_path):
    """A scene with an include below its folder, a mesh beside it, and a texture that is none."""
    for name, text in (
        ("scene/a.xml", SCENE),
        ("scene/wood.png", "no picture"),
        ("scene/parts/defaults.xml", '<mujoco><default><default class="unseen"><geom group="3"/>'
         "</default></default></mujoco>"),
        ("meshes/corner.obj", "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
         + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"),
    ):  # fmt: skip
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, "utf-8")
    return tmp_path / "scene/a.xml"


def test_shapes_are_those_of_the_file_and_a_mesh_is_where_its_points_are(file):
    made = scene(file, users=1)
    said = made.description
    plane, post, mesh, finger = said["shapes"]
    assert (plane["body"], plane["kind"], plane["rgba"]) == ("world", "plane", [1, 0, 0, 1])
    assert plane["size"][:2] == [1.0, 1.0] and plane["at"] == [0.0, 0.0, -0.5]
    assert (post["body"], post["kind"], post["rgba"]) == ("post", "sphere", [0, 1, 0, 1])
    assert (finger["body"], finger["user"], plane["user"]) == ("pmwvc_user1", 0, -1)
    turn = Rotation.from_quat(mesh["turned"], scalar_first=True)
    np.testing.assert_allclose(turn.apply(mesh["points"]) + mesh["at"], CORNERS, atol=2e-6)
    assert sorted(map(sorted, mesh["faces"])) == [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
    half = np.sqrt(0.5)
    np.testing.assert_allclose(said["fixed"]["post"], [0.3, 0, 0, half, 0, 0, half])
    assert set(said["fixed"]) == {"world", "post"} and set(made.poses) == {"body2", "pmwvc_user1"}
    assert said["origin"] == pytest.approx([0.025, 0.025, 0.225])  # a tetrahedron's centre
    assert json.loads(json.dumps(said)) == said


def test_what_is_written_into_a_model_is_said_and_nothing_else(file):
    said = scene(file, users=1).description["options"]
    assert said["cone"] == "elliptic" and said["impratio"] == 100.0 and said["timestep"] == 0.001
    for timestep, used in ((0.05, 0.001), (0.003, 0.001), (0.0007, 0.008 / 12)):
        option = f'<option cone="elliptic" impratio="10" timestep="{timestep}"/>'
        file.write_text(SCENE.replace("<asset>", f"{option}<asset>"), "utf-8")
        said = scene(file, users=1).description["options"]
        assert "cone" not in said and "impratio" not in said
        assert said["timestep"] == pytest.approx(used)
    file.write_text(SCENE.replace("<asset>", '<option timestep="0.0005"/><asset>'), "utf-8")
    assert "timestep" not in scene(file, users=1).description["options"]


def test_the_files_of_a_description_make_the_same_scene_elsewhere(file):
    made = scene(file, users=1)
    assert set(made.description["files"]) == {
        "a.xml",
        "parts/defaults.xml",
        "../meshes/corner.obj",
    }
    assert next(iter(made.description["files"])) == "a.xml"
    scenario = load("lift", settings_texts=[f"server.scene={file}"])
    traces = simulate([replace(scenario, duration_s=0.1)])[0]
    for path in file.parent.parent.rglob("*.*"):
        path.unlink()
    with as_described(scenario, traces.server) as described:
        copy = Path(described.server.scene)
        again = scene(copy, users=1)
        assert again.description == made.description
    assert not copy.exists()
    with as_described(scenario, None) as described:
        assert described is scenario


def test_no_path_of_a_recording_leads_out_of_its_folder(file):
    content = scene(file, users=1).description["files"]["a.xml"]
    for path in ("a/../../../../evil.xml", "/evil.xml", "../../../evil.xml"):
        server = SimpleNamespace(scene={"files": {"a.xml": content, path: content}})
        with as_described(load("lift"), server) as described:
            root = Path(described.server.scene)
            while not root.name.startswith("pmwvc-scene-"):
                root = root.parent
            assert len([*root.rglob("evil.xml")]) == 1


def test_a_scene_is_recorded_and_replayed_without_its_file(tmp_path):
    file = tmp_path / "lift.xml"
    file.write_bytes((CONFIG / "lift.xml").read_bytes())
    haste = ("task.grip_s=0.2", "task.grip_rise_s=0.3", "safety.soft_start_s=0.1")
    scenario = load("lift", settings_texts=[f"server.scene={file}", *haste], duration_s=1.2)
    traces = simulate([scenario])[0]
    assert traces.server.scene == json.loads(json.dumps(scene(file).description))
    record_traces(tmp_path / "session", traces, scenario)
    read = read_session(tmp_path / "session")
    assert read.server.scene == traces.server.scene
    text = file.read_text("utf-8").replace('mass="0.2"', 'mass="0.3"')
    file.write_text(text, "utf-8")
    assert exact(replay(read, scenario, scenario).differences)  # by the file that was recorded
    heavier = tmp_path / "heavier.xml"  # the control
    heavier.write_text(text, "utf-8")
    other = replace(scenario, server=replace(scenario.server, scene=str(heavier)))
    assert not exact(replay(read, scenario, other).differences)
    file.unlink()
    again = replay(read, scenario, scenario)
    assert exact(again.differences)
    assert max(np.abs(user.f_applied).max() for user in read.users) > 1.0  # they held the box
    assert again.replayed.server.scene == read.server.scene
    export(tmp_path / "csv", read, scenario, kind="csv")
    assert "lift.xml" in (tmp_path / "csv" / "parameters.csv").read_text("utf-8")


def test_a_text_that_describes_nothing_is_passed_over(tmp_path):
    scenario = replace(load("lift"), duration_s=0.2)
    record_traces(tmp_path / "session", simulate([scenario])[0], scenario)
    given, said = raw(tmp_path / "session"), read_session(tmp_path / "session").server.scene
    (right,) = (each for each in given if each.topic == "/server/scene")
    texts = [serialize_message(String(data=text)) for text in ("", "no JSON", "[1, 2]", "null")]
    wrong = [right._replace(data=data) for data in (b"", b"\0\1\0\0\xff", *texts)]
    other = right._replace(data=serialize_message(String(data='{"format": 1}')))  # too late
    both = [*wrong, *given, other]
    for name, kept, expected in (("with", both, said), ("without", wrong, {})):
        others = [each for each in given if each is not right] if name == "without" else []
        folder = rewriting.written([*others, *kept], tmp_path / name)
        assert read_session(folder).server.scene == expected


def test_what_is_no_plain_json_is_refused_and_what_has_none_says_nothing(monkeypatch):
    class Jelly:
        def __init__(self, setup):
            self.setup = setup

        def step(self, position, velocity, dt):
            return velocity

    found = {"said": ({"size": (0.1,)},), "wrong": np.zeros(3), "infinite": np.inf}
    kinds = {"jelly": Jelly} | {
        name: type(name, (Jelly,), {"description": {"shapes": shapes}})
        for name, shapes in found.items()
    }
    offer(monkeypatch, environments.PLUGINS.group, "lab_jellies", kinds)

    def box(name):
        server = ServerParams(coupling="unknown", environment=name)
        return Users(server, [ContactParams()]).s.body

    assert description_of(box("jelly")) == description_of(box("wall")) == {}
    assert description_of(box("said")) == {"shapes": [{"size": [0.1]}]}
    for name in ("wrong", "infinite"):
        with pytest.raises(ParameterError, match=r"tion of server.environment cannot be recorded"):
            description_of(box(name))


def test_without_mujoco_the_way_to_it_is_named(monkeypatch, file):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(
        ParameterError, match=r"server.environment = .mujoco.: .*pip install mujoco"
    ):
        scene(file, users=1)
