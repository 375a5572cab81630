# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A box, scene files, and sessions around scenes, at the ends of their ranges: each works, or is
refused in words before anything starts; the report of a scene.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.scenes import scene, written
from support.vendor_setup import vendor_setup

from pmwvc_analysis.events.events import complete
from pmwvc_analysis.figures.motion_charts import forces, positions
from pmwvc_analysis.figures.recorded import conditions
from pmwvc_analysis.report.report import render
from pmwvc_analysis.traces.stages import until
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import scenarios
from pmwvc_bringup.scenarios import load
from pmwvc_bringup.session import surroundings
from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import BodyParams
from pmwvc_core.scenes.body import Box
from pmwvc_core.server.black_box import EnvironmentSetup
from pmwvc_core.simulation.session import simulate
from pmwvc_master.devices import DeviceError
from pmwvc_master.devices.haply import HaplyDevice, HaplyParams

H = 0.008
PEA = """<body name="pea" pos="0 0 1"><freejoint/><geom size="0.01" mass="0.2"/></body>
</worldbody>"""


def box(stiffness=500.0, own=None, **server):
    params = ServerParams(body=own or BodyParams(), **server)
    contact = ContactParams(contact_stiffness=stiffness)
    return Box(EnvironmentSetup(6, H, (-1, 1), params, (contact,) * 2))


@pytest.mark.parametrize(
    "made",
    [
        dict(object_mass=0.001),
        dict(object_mass=0.2, stiffness=1e7),
        dict(object_mass=0.2, own=BodyParams(gravity=0.0)),
    ],
)
def test_forces_come_to_balance_where_rounding_is_larger_than_what_is_wanted(made):
    """Squeezed by hands from nothing to 2 N; the solver raises where it finds no balance."""
    scene, drive = box(**made), np.zeros((2, 6))
    for user, side in enumerate((-1.0, 1.0)):
        scene.join(user, np.array([0.03 * side, 0.0, 0.0, 0.0, 0.0, 0.0]))
    for force in np.concatenate([np.zeros(20), np.geomspace(1e-11, 2.0, 100)]):
        drive[:, 0] = force, -force
        assert abs(scene.meet(drive, np.full(2, 25.0), H)).max() < 0.2
    assert abs(scene.position[:2]).max() < 1e-9 and scene.touching == [True, True]


@pytest.mark.parametrize("mass", [0.2, 1000.0])
def test_a_box_of_any_mass_stands_on_its_table(mass):
    """One of a ton sank deeper than it is high and hopped: 3 mm/s at the hands, "not stable"."""
    scene = box(object_mass=mass)
    for _ in range(50):
        scene.meet(np.zeros((2, 6)), np.full(2, 25.0), H)
    assert abs(scene.position[2]) < 1e-9 and scene.touching == [False, False]


def test_a_pad_wider_than_its_face_is_refused():
    with pytest.raises(ParameterError, match=r"pad_m = 0.04: wider than a side.*; 0.03 at most"):
        box(own=BodyParams(pad_m=0.04))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("server.integrator=trapezoid", "set server.integrator = backward_euler"),
        ("server.object_size_m=1", "outside its workspace of +-0.2 m; make device.workspace_m"),
        ("server.lever_m=1e-6", "server.lever_m = 1e-06: must be 0.001..10 m"),
        ("dof=2", "task.upwards_m = 0.05: there are two axes only; raise dof"),
    ],
)
def test_what_a_scene_cannot_do_is_said_before_there_is_a_folder(text, words):
    with pytest.raises(ScenarioError) as caught:
        surroundings.check(scenarios.load("lift_body", settings_texts=[text]))
    assert all(words in problem for problem in caught.value.problems)


def test_a_session_with_a_scene_can_be_judged_until_a_time_in_it():
    """Every session with a body that ended early, by a fault or in the last second."""
    (traces,) = simulate([scenarios.load("lift_body", duration_s=0.4)])
    cut = until(traces, 0.2)
    assert cut.server.scene == traces.server.scene and cut.server.scene["shapes"]
    assert len(cut.server.poses["box"]) == len(cut.server.time_s) < len(traces.server.time_s)


@pytest.mark.parametrize("service", ["ws://localhost:99999", "localhost", "http://localhost:1"])
def test_an_address_that_is_none_is_refused_by_its_name(service):
    with pytest.raises(DeviceError, match=f"haply.service = '{service}': "):
        HaplyDevice(vendor_setup("haply", 1), HaplyParams(service=service))


@pytest.mark.parametrize("wrong", ["server.object_damping=5", "server.contact=bilateral"])
def test_what_a_box_has_not_is_refused(wrong):
    scenario = scenarios.load("lift_body", settings_texts=[wrong])
    with pytest.raises(ParameterError, match=r"set server\.object_damping = 0"):
        simulate([scenario])


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"scene": ""}, "name the scene's MJCF file (.xml)"),
        ({"scene": "nowhere.xml"}, "server.scene = 'nowhere.xml': there is no such file"),
        ({"handles": "bix, box"}, "no body is named 'bix'; did you mean"),
        ({"handles": "box"}, "server.handles = 'box': 1 bodies for 2 users"),
        ({"handles": "box, box"}, "must be a child of worldbody without joints"),
    ],
)
def test_a_scene_that_cannot_be_used_is_refused_with_a_way_out(tmp_path, values, words):
    given_values = {"scene": written(tmp_path), **values}
    with pytest.raises(ParameterError) as caught:
        scene(given_values.pop("scene"), **given_values)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<body", "<bady", "Line number=3"),
        ('name="table"', 'name="table" material="oak"', "oak"),
        ("-0.0401", "-0.03", "'table' and 'box' overlap"),
        ('name="box"', 'name="pmwvc_user1"', "cannot be used: ValueError: Error: repeated name"),
        ('mass="0.2"', 'mass="20000"', "'box' has 1e+05 times the mass of 'pea'"),
    ],
)
def test_a_scene_file_that_is_wrong_is_refused_with_a_way_out(tmp_path, old, new, words):
    file = Path(written(tmp_path))
    text = file.read_text("utf-8").replace("</worldbody>", PEA)
    file.write_text(text.replace(old, new, 1), "utf-8")
    with pytest.raises(ParameterError) as caught:
        scene(file)
    assert words in str(caught.value)


@pytest.fixture(scope="module")
def door():
    """A door pushed open past its latch."""
    scenario = replace(load("door"), duration_s=7.0)
    return simulate([scenario])[0], scenario


def lines(chart, axis):
    return {line.label: line.y for line in chart.panels[axis].lines}


def test_bodies_that_moved_are_drawn_by_name_and_others_are_not(door):
    traces, scenario = door
    drawn = lines(positions(traces, scenario), 1)
    assert list(drawn) == ["target", "door", "latch", "user1 device", "user1 avatar"]
    assert 1.5 < np.ptp(drawn["latch"]) < 20.0  # pressed in and back [mm]
    latch = traces.server.poses["latch"][:, 1] - traces.server.scene["origin"][1]
    np.testing.assert_allclose(drawn["latch"], latch[: len(drawn["latch"])] * 1e3, atol=1e-6)
    still = {name: rows[:100] for name, rows in traces.server.poses.items()}
    early = replace(traces, server=replace(traces.server, poses=still))
    assert "latch" not in lines(positions(early, scenario), 1)
    crowd = {str(n): n * traces.server.poses["latch"] for n in range(3, 12)} | traces.server.poses
    crowded = replace(traces, server=replace(traces.server, poses=crowd))
    most = ["target", "3", "11", "10", "9", "8", "user1 device", "user1 avatar"]
    assert list(lines(positions(crowded, scenario), 1)) == most
    plain = replace(traces, server=replace(traces.server, scene={}))  # as recorded before
    assert "object" in lines(positions(plain, scenario), 1)


def test_an_axis_that_nothing_uses_is_drawn_as_zero(door):
    traces, scenario = door
    noise = 1e-10 * np.array([[0.0, 0.0, 1.0]])
    users = [replace(u, x_m=u.x_m + noise, f_applied=u.f_applied + noise) for u in traces.users]
    noisy = replace(traces, users=users)
    for chart in (positions(noisy, scenario), forces(noisy, scenario)):
        assert not any(np.nansum(np.abs(y)) for y in lines(chart, 2).values())
        assert all(np.any(y) for label, y in lines(chart, 0).items() if label != "target")


def test_the_note_has_no_contact_law_that_a_scene_does_not_have(door):
    for scenario, has in ((door[1], False), (load("carry_16ms"), True)):
        note = conditions(scenario, "simulated")
        assert (" K = " in note and " B = " in note) is has
        assert "delay 16/16 ms" in note


def test_the_report_says_what_was_written_into_the_model(door):
    scenario = replace(door[1], duration_s=0.4)
    (traces,) = simulate([scenario])
    found = []
    for written_in in (traces.server.scene, {}):
        said = replace(traces, server=replace(traces.server, scene=written_in))
        page = render(said, scenario, summary(said, scenario), [])
        found += [re.findall(r"Scene options, written into the model[^<]*", page)]
    ((text,), nothing) = found
    assert ": cone elliptic, impratio 100.0, " in text
    assert not nothing


def test_how_other_bodies_of_a_scene_turn_is_not_drawn(tmp_path):
    """A report of six axes and two bodies that move ended with an IndexError."""
    file = Path(written(tmp_path))
    file.write_text(file.read_text("utf-8").replace("</worldbody>", PEA), "utf-8")
    scenario = load("lift", duration_s=0.5, settings_texts=[f"server.scene={file}", "dof=6"])
    chart = positions(simulate([scenario])[0], scenario)
    assert ["pea" in lines(chart, axis) for axis in range(6)] == [True] * 3 + [False] * 3


def test_a_torque_at_its_limit_is_named_in_newton_metres():
    """Recorded at the lever [N]; with 0.01 mN m allowed one soon is, by default none."""
    found = {}
    for torque_n_m in (1e-5, 0.0):
        settings = [f"safety.max_torque={torque_n_m}", "safety.soft_start_s=0.1"]
        scenario = load("turn", duration_s=3.4, settings_texts=settings)
        traces = simulate([scenario])[0]
        found[torque_n_m] = {e["what"] for e in complete(traces, scenario) if e["kind"] == "limit"}
        (contact, *_) = (
            e["what"] for e in complete(traces, scenario) if "contact made" in e["what"]
        )
        assert re.fullmatch(r"contact made; up to [\d.]+ N and [\d.]+ N m until .* s", contact)
        labels = [panel.y_label for panel in forces(traces, scenario).panels[:6]]
        assert (labels[0], labels[3]) == ("force, x [N]", "torque, about x [N m]")
    (text, *_) = found[1e-5]
    acted = r"torque limited for [\d.]+ s of [\d.]+ s"
    assert re.match(acted + r": up to [\d.]+ N m commanded, 0.0000 N m", text)
    assert not any(text.startswith("torque") for text in found[0.0])
