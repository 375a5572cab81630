# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes unlike the shipped ones, with two users over a network that loses packets and is late."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.scenes import loaded, scene, written
from support.simulated import least_j

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.events.events import complete
from pmwvc_bringup.scenarios import load
from pmwvc_core.simulation.session import simulate_one

SCENARIO = """
name: foreign
controller: pmwvc
users: 2
dof: {dof}
duration_s: 2.0
server: {{coupling: unknown, environment: mujoco, scene: "my scene.xml", store_j: 0.0}}
master: {{store_j: 0.0}}
task: {{kind: carry, grip_s: 0.2, grip_rise_s: 0.4, move_s: 1.0, distance_m: 0.03}}
operator: {{stiffness: 120.0, damping: 15.0, squeeze: 2.0}}
link: {{delay_s: 0.012, jitter: uniform, jitter_s: 0.012, loss: 0.1}}
"""
ROD = 'type="capsule" fromto="0 0 0 0 0.06 0" size="0.008" mass="0.05"'
CART = "a ball on a cart on a spring, long implicit steps, a geom that touches nothing"
ROBOT = "as of robots: a table of tons, a mark on a hand, mocap, a key, long steps, a lit texture"
SCENES = {
    "a chain of hinges, gravity sideways, short implicit steps": f"""<mujoco>
<option timestep="0.0005" integrator="implicitfast" gravity="0 9.81 0"/><worldbody>
<body name="link one"><joint axis="0 0 1" damping="0.01"/><geom {ROD}/>
<body name="link two" pos="0 0.06 0"><joint axis="1 0 0" range="-60 60"/><geom {ROD}/></body>
</body></worldbody></mujoco>""",
    CART: """<mujoco>
<option timestep="0.005" integrator="implicit"/><worldbody><body name="cart">
<joint type="slide" axis="1 0 0" stiffness="20" damping="1"/>
<geom type="box" size="0.03 0.03 0.01" mass="0.2"/><body pos="0 0 0.012"><joint type="ball"/>
<geom size="0.01" mass="0.02" contype="0" conaffinity="0"/></body></body></worldbody></mujoco>""",
    "two bodies on a tendon, two welded, a keyframe and a motor": """<mujoco><worldbody>
<geom type="plane" size="1 1 .1" pos="0 0 -0.021"/>
<body name="left"><freejoint/><geom size="0.02" mass="0.1" condim="6"/><site name="a"/></body>
<body pos="0.08 0 0"><freejoint/><geom size="0.02" mass="0.1"/><site name="b"/></body>
<body name="c" pos="0 0.1 0"><joint name="c" type="slide"/><geom size="0.01" mass="0.1"/></body>
<body name="d" pos="0 0.15 0"><joint type="slide"/><geom size="0.01" mass="0.1"/></body>
</worldbody><tendon><spatial stiffness="50" damping="1"><site site="a"/><site site="b"/></spatial>
</tendon><equality><weld body1="c" body2="d"/></equality><actuator><motor joint="c"/></actuator>
<keyframe><key ctrl="1"/></keyframe></mujoco>""",
    ROBOT: """<mujoco><option timestep="0.02"/>
<asset><texture name="spot" type="2d" builtin="flat" width="4" height="4"/></asset><worldbody>
<light pos="0 0 1" texture="spot"/>
<body name="table" pos="0 0 -0.0405"><geom type="box" size=".3 .3 .01" mass="5000"/></body>
<body name="box"><freejoint/><geom type="box" size=".03 .03 .03" mass="0.2"/></body>
<body name="aim" mocap="true" pos="0 0.1 0.05"><geom size="0.005" mass="1e-9"/></body>
<body name="hand" pos="0 0.1 0.05"><freejoint/><geom size="0.02" mass="0.1"/>
<body pos="0 0 0.03"><geom size="0.002" mass="1e-7"/></body></body>
</worldbody><equality><weld body1="aim" body2="hand"/></equality><contact>
<exclude body1="aim" body2="hand"/></contact><keyframe><key mpos="0 0 1"/></keyframe></mujoco>""",
    "bodies without names, Runge-Kutta, pyramids": """<mujoco>
<option integrator="RK4" cone="pyramidal" impratio="5"/><worldbody>
<geom type="box" size=".3 .3 .01" pos="0 0 -0.036"/>
<body><freejoint/><geom type="ellipsoid" size="0.03 0.02 0.025" mass="0.15"/></body>
<body pos="0.09 0 0"><freejoint/><geom type="box" size="0.02 0.02 0.02" mass="0.1"/></body>
</worldbody></mujoco>""",
}


def foreign(folder, text, dof, *settings):
    """Return a scenario around a scene."""
    (folder / "my scene.xml").write_text(text, "utf-8")
    file = folder / "foreign.yaml"
    file.write_text(SCENARIO.format(dof=dof), "utf-8")
    return load(str(file), settings_texts=settings)


def server_least_j(server):
    """Return the least that all ports of the server have got more than they gave [J]."""
    power = np.sum(np.square(server.u_s) - np.square(server.v_s), axis=(0, 2))
    return np.cumsum(0.5 * server.period_s * power).min()


@pytest.mark.parametrize(("name", "dof"), [*zip(SCENES, (3, 6, 3, 3, 6), strict=True)])
def test_no_channel_gives_out_more_than_it_got(tmp_path, name, dof):
    scenario = foreign(tmp_path, SCENES[name], dof)
    traces = simulate_one(scenario)
    for energy in user_energies(traces, scenario):
        assert energy.parts["up"].declared_j == 0.0 and least_j(energy) >= -1e-12
    assert server_least_j(traces.server) >= -1e-12
    assert not traces.server.contained.any()
    assert max(np.abs(np.concatenate(traces.server.f_s)).max(axis=0)) > 0.1


def test_hands_that_meet_nothing_touch_nothing(tmp_path):
    """Late packets push fingers of a gram: their forces are no contacts."""
    ghost = """<mujoco><option gravity="0 0 0"/><worldbody><body><freejoint/>
    <geom size="0.03" mass="1" contype="0" conaffinity="0"/></body></worldbody></mujoco>"""
    scenario = foreign(tmp_path, ghost, 3, "operator.squeeze=0")
    traces = simulate_one(scenario)
    assert np.any(traces.server.f_s)
    kinds = {each["kind"] for each in complete(traces, scenario)}
    assert not kinds & {"grip", "release", "slip", "drop"}, kinds


RING = " ".join(
    f'<geom type="box" size="0.05 0.01 0.03" pos="0 {y} {z}" euler="{turn} 0 0" mass="0.1"/>'
    for y, z, turn in ((0.04, 0, 0), (-0.04, 0, 0), (0, 0.04, 90), (0, -0.04, 90))
)


@settings(max_examples=20, deadline=None)
@given(
    half_m=st.floats(0.005, 0.15), finger_m=st.floats(0.002, 0.02), given_m=st.floats(0.01, 0.1),
    kind=st.sampled_from(["box", "edge", "sphere", "margin", "fallen", "ring"]),
    dof=st.sampled_from([3, 6]),
)  # fmt: skip
def test_a_finger_begins_at_the_face_of_a_body_of_any_width(
    tmp_path_factory, half_m, finger_m, given_m, kind, dof
):
    """The first body that moves, where it settled; a hollow one is no face. The control: from a
    device at the face of an object that is a tenth wider nothing is touched.
    """
    turn, margin = 45.0 * (kind == "edge"), 0.002 * (kind == "margin")
    size = f"{half_m} {half_m if kind == 'edge' else 0.03} 0.03"
    geom = f'type="box" size="{size}" euler="0 0 {turn}" margin="{margin}"'
    geom = f'type="sphere" size="{half_m}"' if kind == "sphere" else geom
    geom = RING if kind == "ring" else f'<geom {geom} mass="0.2"/>'
    file = tmp_path_factory.mktemp("scene") / "any.xml"
    file.write_text(
        f"""<mujoco><option gravity="0 0 {-0.1 * (kind == "fallen")}"/><worldbody>
        <body pos="0.3 0 0.1"><freejoint/><geom size="0.3" mass="0.01" contype="0"
        conaffinity="0"/>{geom}</body></worldbody></mujoco>""",
        "utf-8",
    )
    made = loaded(
        file, dof=dof, finger_m=finger_m, object_size_m=2.0 * given_m, settle=kind == "fallen"
    )
    face_m = {"edge": half_m * 2**0.5, "ring": given_m}.get(kind, half_m) + margin
    for nearer_m in (-0.1 * given_m, 5e-5):
        for user, side in enumerate((-1, 1)):
            made.join(user, side * (given_m - nearer_m) * np.eye(dof)[0])
        made.meet(np.zeros((2, dof)), np.full(2, 8.0), 0.008)
        assert made.touching == [nearer_m > 0.0 and kind != "ring"] * 2
    middle = made.poses["body1"]
    for user, side in enumerate((-1, 1)):
        finger = made.poses[f"pmwvc_user{user + 1}"]
        way_m = np.array(finger[:3]) - side * (face_m + finger_m) * np.eye(3)[0] - middle[:3]
        np.testing.assert_allclose(way_m, 0.0, atol=2e-3)


@pytest.mark.parametrize("period_s", [0.0005, 0.0085, 0.02])
def test_a_step_of_any_length_moves_for_its_whole_length(tmp_path, period_s):
    """A port alone moves with drive/b; of 8.5 ms not 8 sub-steps of 1 ms."""
    made = scene(written(tmp_path, gravity="0 0 0"), users=1)
    made.join(0, np.array([-0.1, 0.0, 0.0]))
    before = made.poses["pmwvc_user1"][2]
    for _ in range(20):
        v = made.meet(np.array([[0.0, 0.0, 0.8]]), np.full(1, 8.0), period_s)
        way_m, before = made.poses["pmwvc_user1"][2] - before, made.poses["pmwvc_user1"][2]
        assert way_m == pytest.approx(v[0, 2] * period_s, rel=1e-9)


def test_soft_bodies_are_loaded_and_one_that_is_unstable_is_put_back(tmp_path):
    """The lowest points of the first are 18 mm above the plane; the other has no springs."""
    file = tmp_path / "soft.xml"
    for more in ('<edge equality="true"/>', '<edge damping="1"/>'):
        file.write_text(
            f"""<mujoco><worldbody><geom type="plane" size="1 1 1"/><flexcomp name="soft"
            type="grid" count="4 4 4" spacing="0.02 0.02 0.02" pos="0 0 0.05" dim="3"
            radius="0.002" mass="0.2"><contact selfcollide="none"/>{more}</flexcomp>
            </worldbody></mujoco>""",
            "utf-8",
        )
        made, failed = loaded(file), []
        for _ in range(30):
            try:
                made.meet(np.zeros((2, 3)), np.full(2, 8.0), 0.008)
            except RuntimeError as error:
                failed.append(str(error))
            assert np.isfinite(made.data.qpos).all() and np.isfinite(made.data.qvel).all()
        assert bool(failed) == ("damping" in more)
        assert all("unstable at body 'soft_" in each for each in failed)


def test_a_mocap_body_can_be_the_handle_that_leads_a_hand(tmp_path):
    (tmp_path / "robot.xml").write_text(SCENES[ROBOT], "utf-8")
    made = scene(tmp_path / "robot.xml", users=1, handles="aim")
    before = made.poses["hand"]
    for _ in range(50):
        moved = made.meet(np.array([[0.0, 0.0, 2.0]]), np.full(1, 25.0), 0.008)
    aim, hand = made.poses["aim"], made.poses["hand"]
    assert hand[2] - before[2] == pytest.approx(aim[2] - 0.05, abs=1e-3)
    speed = (2.0 - 0.1 * 9.81) / 25.0  # the port carries the hand's weight
    assert aim[2] - 0.05 == pytest.approx(0.4 * speed, rel=0.02)
    assert moved[0, 2] == pytest.approx(speed, rel=0.02)


def test_without_the_ledger_a_spring_under_tension_gives_out_what_it_holds(tmp_path):
    """The control."""
    taut = SCENES[CART].replace('damping="1"', 'springref="0.1"')
    for compensation, kept in (("none", False), ("ledger", True)):
        scenario = foreign(tmp_path, taut, 3, f"server.compensation={compensation}")
        assert (server_least_j(simulate_one(scenario).server) >= -1e-12) == kept
