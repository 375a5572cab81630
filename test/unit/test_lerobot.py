# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Arms of LeRobot: joints to the hand by a table, forces to torques of the same power; a module of
a laboratory stands for the library.
"""

import contextlib
import dataclasses
import math
import sys
import time
import types

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.vendor_setup import vendor_setup, whole

from pmwvc_core.errors import DeviceError
from pmwvc_master.devices import lerobot
from pmwvc_master.devices.lerobot import LerobotDevice, LerobotParams, hand_of

PATIENCE_S = 30.0
angles = st.floats(-3.0, 3.0)
rows = st.lists(
    st.tuples(
        st.just("j"), st.floats(-0.3, 0.3), angles, st.floats(-0.3, 0.3), angles,
        st.floats(0.1, 2.0),
    ),
    min_size=1, max_size=6,
)  # fmt: skip


@given(rows, st.data())
def test_the_jacobian_is_the_slope_of_the_hand(rows, data):
    """By central differences."""
    units = np.array([data.draw(angles) for _ in rows])
    scale = np.array([row[-1] for row in rows])
    _, jacobian = hand_of(rows, units)
    h = 1e-6
    for joint in range(len(rows)):
        step = np.zeros(len(rows))
        step[joint] = h / scale[joint]
        slope = (hand_of(rows, units + step)[0] - hand_of(rows, units - step)[0]) / (2 * h)
        np.testing.assert_allclose(jacobian[:, joint], slope, atol=1e-8)


@given(angles, angles)
def test_a_planar_chain_is_where_its_closed_form_is(one, two):
    rows = [("a", 0.2, 0.0, 0.0, 0.0, 1.0), ("b", 0.1, 0.0, 0.03, 0.0, 1.0)]
    x, _ = hand_of(rows, np.array([one, two]))
    s1, c1, s12, c12 = np.sin(one), np.cos(one), np.sin(one + two), np.cos(one + two)
    np.testing.assert_allclose(x, [0.2 * c1 + 0.1 * c12, 0.2 * s1 + 0.1 * s12, 0.03], atol=1e-15)
    turned = [("a", 0.2, 0.0, 0.0, one, 1.0), ("b", 0.1, 0.0, 0.03, two, 2.0)]
    np.testing.assert_allclose(hand_of(turned, np.zeros(2))[0], x, atol=1e-15)


PROFILE = """
joints:
  source: drawing of the arm
  value:
  - [shoulder, 0.2, 0, 0, 0, 0.017453292519943295]
  - [elbow, 0.1, 0, 0, 0, 0.017453292519943295]
workspace_m: {value: 0.3, source: sum of the links}
max_force_n: {value: 3, source: measured}
"""


@dataclasses.dataclass
class Config:
    port: str = ""
    id: str = ""


class Arm:
    """A teleoperator with two joints; degrees, as LeRobot's."""

    config_class = Config
    is_calibrated, takes, wrong = True, True, ""
    feedback_features = dict.fromkeys(
        f"{joint}.{word}" for joint in ("shoulder", "elbow") for word in ("torque", "effort")
    )
    made = None

    def __init__(self, config):
        self.config, self.sent, self.connected = config, [], False
        self.action = {"shoulder.pos": 90.0, "elbow.pos": -90.0, "gripper.pos": 3.0}
        type(self).made = self

    def connect(self, calibrate=True):
        assert not calibrate
        self.connected = True

    def get_action(self):
        time.sleep(0.002)
        if self.wrong:
            raise ConnectionError(self.wrong)
        return dict(self.action)

    def send_feedback(self, feedback):
        if not self.takes:
            raise NotImplementedError
        self.sent.append(feedback)

    def disconnect(self):
        self.connected = False


@pytest.fixture
def lab(monkeypatch, tmp_path):
    """A laboratory's teleoperator and its profile; returns what makes and opens the device."""
    kind = type("LabArm", (Arm,), {})
    module = types.ModuleType("lab_arm")
    module.LabArm = kind
    monkeypatch.setitem(sys.modules, "lab_arm", module)
    monkeypatch.setattr(lerobot, "PAUSE_S", 0.001)
    file = tmp_path / "arm.yaml"
    file.write_text(PROFILE)
    usual = {"model": str(file), "teleoperator": "lab_arm:LabArm", "config": "port=/dev/lab0"}
    with contextlib.ExitStack() as ends:

        def opened(dof=2, **params):
            device = whole(LerobotDevice, LerobotParams(**usual | params), "lerobot", dof)
            ends.callback(device.close)
            device.open()
            return device

        opened.kind, opened.file = kind, file
        yield opened


def until(there):
    end = time.monotonic() + PATIENCE_S
    while not there():
        assert time.monotonic() < end
        time.sleep(0.001)


def pushed(device, f_m, key="shoulder.torque"):
    """Push, as a loop that does not stall, until the arm has it; return the torques."""
    arm, f_m = type(device._arm).made, np.array(f_m)
    until(lambda: device.write(f_m) or arm.sent[-1][key] != 0.0)
    return next(each for each in arm.sent if each[key] != 0.0)


def test_the_hand_is_where_the_joints_are_and_torques_are_those_of_the_force(lab):
    device = lab()
    sample = device.read(time.monotonic_ns())
    np.testing.assert_allclose(sample.x, [0.1, 0.2], atol=1e-12)
    assert device.info.max_force == 3 and sample.valid
    sent = pushed(device, [-2.0, -1.0])  # (2, 1) N on the hand
    expected = np.array([[-0.2, 0.1], [0.0, 0.1]]) @ [2.0, 1.0]  # J^T f at 90 and -90 degrees
    np.testing.assert_allclose([*sent.values()], expected, atol=1e-12)
    assert list(sent) == ["shoulder.torque", "elbow.torque"]


def test_a_loop_that_stalls_leaves_no_torque_and_close_takes_it_away(lab):
    device = lab(feedback="effort")
    arm = lab.kind.made
    pushed(device, [1.0, 0.0], "shoulder.effort")
    until(lambda: not any(arm.sent[-1].values()))
    device.write(np.array([1.0, 0.0]))
    device.close()
    assert not any(arm.sent[-1].values()) and not arm.connected
    device.close()


def test_velocities_are_the_slope_of_the_hand(lab):
    device = lab()
    arm, begin = lab.kind.made, time.monotonic()
    arm.get_action = lambda: {
        "shoulder.pos": 57.29577951 * (time.monotonic() - begin), "elbow.pos": -0.0,
    }  # fmt: skip
    speeds = []
    while len(speeds) < 50:
        sample = device.read(time.monotonic_ns())
        speeds += [float(np.linalg.norm(sample.xd))] if sample.fresh else []
    assert np.median(speeds) == pytest.approx(0.3, rel=0.05)  # 1 rad/s at 0.3 m


def test_a_joint_that_is_no_number_gets_no_torque_that_is_none(lab):
    device = lab()
    arm = lab.kind.made
    pushed(device, [1.0, 0.0])
    arm.action["elbow.pos"] = math.nan
    until(
        lambda: not (device.write(np.array([1.0, 0.0])) or device.read(time.monotonic_ns()).valid)
    )
    until(lambda: not any(arm.sent[-1].values()))
    assert np.isfinite([[*each.values()] for each in arm.sent]).all()


def test_a_bus_that_fails_makes_samples_invalid_until_it_speaks_again(lab):
    device = lab()

    def valid():
        device.write(np.zeros(2))
        return device.read(time.monotonic_ns()).valid

    lab.kind.wrong = "no answer of servo 1"
    until(lambda: not valid())
    lab.kind.wrong = ""
    until(valid)


def test_two_masters_on_one_bus_are_refused_by_its_port_and_no_arm_is_named(lab):
    lab()
    with pytest.raises(DeviceError, match="lerobot: device /dev/lab0: another master has"):
        lab()


@pytest.mark.parametrize(
    ("arm", "params", "text"),
    [
        ({}, {"teleoperator": "lab_leg:Leg"}, "cannot be opened: ModuleNotFound"),
        ({}, {"teleoperator": "lab_arm:Leg"}, "cannot be opened: AttributeError"),
        ({}, {"config": "speed=3"}, "cannot be opened: TypeError"),
        ({}, {"config": "port"}, "cannot be opened: ValueError"),
        ({"is_calibrated": False}, {}, r"LabArm', .*lab0' is not calibrated: lerobot-calibrate"),
        ({"feedback_features": {}}, {}, r"takes no elbow\.torque, but nothing"),
        ({}, {"feedback": "pos"}, r"takes no elbow\.pos, but \['shoulder\.torque', "),
        ({"takes": False}, {}, "cannot be opened: NotImplementedError"),
        ({"wrong": "no port"}, {}, "'port=/dev/lab0' cannot be opened: ConnectionError: no"),
        ({}, {"model": ""}, r"lerobot\.model = '': must be a YAML file with a profile"),
    ],
)
def test_what_cannot_be_opened_is_refused_with_the_reason(lab, arm, params, text):
    for name, value in arm.items():
        setattr(lab.kind, name, value)
    with pytest.raises(DeviceError, match=text):
        lab(**params)
    assert lab.kind.made is None or not lab.kind.made.connected


def test_a_table_that_is_none_is_refused(lab):
    lab.file.write_text(PROFILE.replace("- [elbow, 0.1, 0,", "- [elbow, 0.1,"))
    with pytest.raises(DeviceError, match=r"joints of .*arm\.yaml cannot be made: "):
        lab()


def test_nothing_is_imported_before_the_device_is_opened_and_the_library_is_named(lab):
    LerobotDevice(
        vendor_setup("lerobot"), LerobotParams(str(lab.file), teleoperator="nowhere:Arm")
    )
    with pytest.raises(DeviceError, match="pip install lerobot"):
        LerobotDevice.look()
