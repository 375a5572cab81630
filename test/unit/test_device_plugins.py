# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Devices by name: what is installed, and what is said of one that cannot be used."""

import re
import sys
from pathlib import Path

import pytest
from support.lab import offer

from pmwvc_core.errors import DeviceError, ParameterError
from pmwvc_core.params import DeviceParams, OperatorParams, TaskParams
from pmwvc_core.plugins import installed
from pmwvc_master import devices as plugins
from pmwvc_master.devices import DeviceInfo, DeviceSetup


def setup(**changes):
    values = {
        "dof": 1,
        "tick_s": 0.001,
        "side": -1,
        "half_width_m": 0.03,
        "start_m": -0.03,
        "seed": 1,
        "device": DeviceParams(),
        "operator": OperatorParams(kind="constant", force=1.0),
        "task": TaskParams(),
    }
    return DeviceSetup(**(values | changes))


class Stick:
    """A device that does nothing."""

    def __init__(self, setup):
        self.info = DeviceInfo(model="stick", dof=1)

    def open(self): ...
    def read(self, due_ns): ...
    def write(self, f_m): ...
    def couple(self): ...
    def stop(self): ...
    def close(self): ...


@pytest.fixture
def lab(monkeypatch):
    """A laboratory's own module with plug-ins, beside those of the project."""

    def broken(setup):
        raise OSError("no device on /dev/stick0")

    def picky(setup):
        raise ParameterError("device.mass = 1.0: a stick weighs less")

    found = {"stick": Stick, "stone": lambda _: object(), "broken": broken, "picky": picky}
    known = installed(plugins.PLUGINS.group).values()
    absent = "lab_vendor_library:Device"
    offer(monkeypatch, plugins.PLUGINS.group, "lab_devices", found, kept=known, absent=absent)


def test_the_projects_own_devices_are_installed():
    assert {"simulated", "ros_topic"} <= set(installed(plugins.PLUGINS.group))


def test_a_device_of_another_package_is_made(lab):
    assert isinstance(plugins.make_device("stick", setup()), Stick)


def test_an_unknown_name_is_answered_with_what_is_installed():
    with pytest.raises(DeviceError, match=r"'touch': not installed; .*ros_topic, simulated"):
        plugins.make_device("touch", setup())


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("absent", r"lab_vendor_library:Device\) cannot be imported: ModuleNotFoundError"),
        ("broken", r"lab_devices:broken\) cannot be made: OSError: no device on /dev/stick0"),
        ("stone", r"is not a device: it lacks open, read, write, couple, stop, close, info"),
    ],
)
def test_a_plug_in_that_fails_is_named_with_the_reason(lab, name, text):
    with pytest.raises(DeviceError, match=text):
        plugins.make_device(name, setup())


def test_what_a_device_states_of_its_settings_is_passed_on_as_it_is(lab):
    with pytest.raises(ParameterError, match=r"^device.mass = 1.0: a stick weighs less$"):
        plugins.make_device("picky", setup())


def test_a_device_of_other_axes_is_refused(lab):
    with pytest.raises(DeviceError, match="has 1 axes where dof = 2"):
        plugins.make_device("stick", setup(dof=2))


def test_the_ros_device_needs_a_node():
    with pytest.raises(DeviceError, match="needs a ROS node"):
        plugins.make_device("ros_topic", setup())


def test_poses_have_no_more_than_three_axes_of_motion():
    with pytest.raises(DeviceError, match="'ros_topic': poses have 3 axes of motion; set dof = 4"):
        plugins.make_device("ros_topic", setup(dof=4, node=object()))


def test_the_device_of_the_documentation_works(lab):
    text = (Path(__file__).resolve().parents[2] / "docs" / "devices.md").read_text("utf-8")
    [source] = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names = vars(sys.modules["lab_devices"])
    exec(compile(source, "docs/devices.md", "exec"), names)
    names["stick"] = names["Stick"]
    device = plugins.make_device("stick", setup())
    device.open()
    device.write(-1.0)
    for _ in range(1000):
        sample = device.read(0)
    assert sample.xd == pytest.approx(5.0)  # 1 N on 0.2 kg for 1 s
    device.stop()
    assert device.read(0).xd == sample.xd
