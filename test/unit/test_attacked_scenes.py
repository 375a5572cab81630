# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A box, and sessions around scenes, at the ends of their ranges: each works, or is refused in
words before anything starts.
"""

import dataclasses

import numpy as np
import pytest
from support.vendor_setup import vendor_setup

from pmwvc_analysis.traces.stages import until
from pmwvc_analysis.transparency.answer import sentences
from pmwvc_analysis.transparency.transparency import Rendering
from pmwvc_bringup import scenarios
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
    assert abs(scene.position[:2]).max() < 1e-9


@pytest.mark.parametrize("mass", [0.2, 1000.0])
def test_a_box_of_any_mass_stands_on_its_table(mass):
    """One of a ton sank deeper than it is high and hopped: 3 mm/s at the hands, "not stable"."""
    scene = box(object_mass=mass)
    for _ in range(50):
        scene.meet(np.zeros((2, 6)), np.full(2, 25.0), H)
    assert abs(scene.position[2]) < 1e-9


def test_a_pad_wider_than_its_face_is_refused():
    with pytest.raises(ParameterError, match=r"pad_m = 0.04: wider than a side.*; 0.03 at most"):
        box(own=BodyParams(pad_m=0.04))


ROWS = "; ".join(
    " ".join("25" if row == column else "0" for column in range(6)) for row in range(6)
)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"server.impedance_matrix={ROWS}", "one number for all axes: remove impedance_matrix"),
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


def test_nothing_known_of_a_rendering_is_said_in_a_word():
    nothing = dataclasses.asdict(Rendering())
    found = dict(nothing, user="user1", source="law", ideal=nothing, measured=None, notes=[])
    assert sentences(found) == ["user1, through the link: unknown", "ideal: unknown"]


@pytest.mark.parametrize("service", ["ws://localhost:99999", "localhost", "http://localhost:1"])
def test_an_address_that_is_none_is_refused_by_its_name(service):
    with pytest.raises(DeviceError, match=f"haply.service = '{service}': "):
        HaplyDevice(vendor_setup("haply", 1), HaplyParams(service=service))


@pytest.mark.parametrize("wrong", ["server.object_damping=5", "server.contact=bilateral"])
def test_what_a_box_has_not_is_refused(wrong):
    scenario = scenarios.load("lift_body", settings_texts=[wrong])
    with pytest.raises(ParameterError, match=r"set server\.object_damping = 0"):
        simulate([scenario])
