# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Devices by name: what is installed, what is said of one that cannot be used; declarations hold,
and settings that do not fit are reported.
"""

import itertools
import math
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from support.lab import offer
from support.packer import Packer
from support.peers import ros

from pmwvc_core.errors import DeviceError, ParameterError
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.params import DeviceParams, MasterParams, OperatorParams, SafetyParams, TaskParams
from pmwvc_core.plugins import installed
from pmwvc_master import devices as plugins
from pmwvc_master.devices import (
    DeviceInfo,
    DeviceSample,
    DeviceSetup,
    limits_of,
    warnings_of_device,
)
from pmwvc_master.devices.mapped import make_device
from pmwvc_master.settings import declare_settings


def setup(**changes):
    values = {
        "dof": 1,
        "tick_s": 0.001,
        "side": -1,
        "half_width_m": 0.03,
        "start_m": -0.03,
        "lever_m": 0.05,
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


@pytest.mark.parametrize(
    ("name", "changes", "text"),
    [
        ("glove", {}, r"'glove': not installed; .*ros_topic, simulated"),
        ("absent", {}, r"lab_vendor_library:Device\) cannot be imported: ModuleNotFoundError"),
        ("broken", {}, r"lab_devices:broken\) cannot be made: OSError: no device on /dev/stick0"),
        ("stone", {}, r"is not a device: it lacks open, read, write, couple, stop, close, info"),
        ("picky", {}, r"^device.mass = 1.0: a stick weighs less$"),
        ("stick", {"dof": 2}, "has 1 axes; set dof = 2 to 1 or less"),
        ("ros_topic", {}, "needs a ROS node"),
        ("ros_topic", {"dof": 4, "node": object()}, "dof = 4: must be 1 to 3, or 6"),
    ],
)
def test_a_device_that_cannot_be_used_is_named_with_the_reason(lab, name, changes, text):
    kind = ParameterError if name == "picky" else DeviceError
    with pytest.raises(kind, match=text):
        make_device(name, setup(**changes))


def test_the_device_of_the_documentation_works(lab):
    text = (Path(__file__).resolve().parents[2] / "docs" / "devices.md").read_text("utf-8")
    [source] = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names = vars(sys.modules["lab_devices"])
    exec(compile(source, "docs/devices.md", "exec"), names)
    names["stick"] = names["Stick"]
    device = make_device("stick", setup())
    device.open()
    device.write(-1.0)
    for _ in range(1000):
        sample = device.read(0)
    assert sample.xd == pytest.approx(5.0)  # 1 N on 0.2 kg for 1 s
    device.stop()
    assert device.read(0).xd == sample.xd


def info(**declared):
    return DeviceInfo(model="stick", dof=1, **declared)


@pytest.mark.parametrize(
    ("declared", "expected"),
    [
        ({}, 8.0),
        ({"max_force": 0.5}, 0.5),
        ({"max_force": 3.3, "continuous_force": 0.88}, 3.3),
        ({"continuous_force": 0.88}, 0.88),
        ({"max_force": 30.0}, 8.0),
    ],
)
def test_the_force_limit_is_never_above_the_devices_peak(declared, expected):
    assert limits_of(info(**declared), SafetyParams()) == SafetyParams(max_force=expected)


@pytest.mark.parametrize("name", ["max_force", "continuous_force", "apparent_mass", "workspace_m"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_a_declaration_that_cannot_be_is_refused(name, value):
    with pytest.raises(DeviceError, match=f"stick: declares {name} = .*must be > 0"):
        limits_of(info(**{name: value}), SafetyParams())


class Rig:
    """The force loop that the node makes for a device, pushed against a wave of 5 N."""

    def __init__(self, declared):
        with ros(automatically_declare_parameters_from_overrides=True) as peer:
            settings = declare_settings(peer.node, lambda _: None, lambda _: None)
        self.loop = settings.make_force_loop(1, declared)
        self.packer = Packer(2, period=settings.server.period_s)
        self.tick = 0

    def force(self, x=0.0, xd=0.0, *, ticks=1, outside=False):
        forces = []
        for _ in range(ticks):
            now_ns, packets = self.tick * 1_000_000, []
            if self.tick % 8 == 0:
                packets = [self.packer.pack(-5.0 / math.sqrt(50.0), 0.0, now_ns)]
            sample = DeviceSample(x=x, xd=xd, outside=outside)
            forces.append(self.loop.tick(self.tick, now_ns, sample, packets)[0])
            self.tick += 1
        return forces


def test_a_device_that_declares_half_a_newton_is_never_driven_with_more():
    forces = Rig(info(max_force=0.5)).force(ticks=1000)
    assert max(forces) == 0.5
    control = Rig(info()).force(ticks=1000)
    assert max(control) == pytest.approx(5.0, rel=0.01)


def test_beyond_the_workspace_a_force_only_brakes():
    """Wherever its avatar is."""
    rig, beyond = Rig(info(workspace_m=0.1)), {"x": 0.103, "outside": True}
    assert rig.force(x=0.1, ticks=1000)[-1] == pytest.approx(5.0, rel=0.01)
    assert rig.force(x=0.103, ticks=50)[-1] == pytest.approx(5.0, rel=0.01)
    pushed = rig.force(**beyond, ticks=50)
    assert pushed[-1] == 0.0
    assert max(abs(a - b) for a, b in itertools.pairwise(pushed)) < 2.1
    assert rig.loop.state == SafetyState.DAMPING
    assert rig.loop.reason == "beyond the device's workspace: damping only"
    assert rig.force(**beyond, xd=0.2, ticks=30)[-1] > 0.0  # against the motion
    assert rig.force(**beyond, xd=-0.2, ticks=30)[-1] <= 0.0
    back = rig.force(x=0.09, ticks=600)
    assert max(back[:20]) < 0.3 and back[-1] == pytest.approx(5.0, rel=0.01)


def warned(
    declared, master, device, *, force_n=3.0, waves=True, strict=True, torque_n_m=0.15
):  # fmt: skip
    options = {"force_n": force_n, "waves": waves, "strict": strict, "torque_n_m": torque_n_m}
    return list(warnings_of_device(declared, master, device, **options))


def test_a_force_above_the_continuous_one_is_named_before_the_motors_heat():
    lasting = info(max_force=3.3, continuous_force=0.88)
    (text,) = warned(lasting, MasterParams(), DeviceParams(), force_n=3.3)
    assert text.startswith("safety.max_force = 3.3 N: the device holds 0.88 N for long")
    assert not warned(lasting, MasterParams(), DeviceParams(), force_n=0.88)
    assert not warned(info(max_force=3.3), MasterParams(), DeviceParams(), force_n=3.3)


def test_a_torque_that_no_motor_declares_is_named_before_it_is_felt():
    """One of max_force at the lever; a device that renders none has nothing to declare."""
    turns = DeviceInfo("turns", 6)
    lab = DeviceParams(plugin="lab")
    (text,) = warned(turns, MasterParams(), lab, torque_n_m=0.25)
    assert text.startswith("safety.max_torque = 0.25 N m, max_force at the lever: the device decl")
    assert not warned(turns, MasterParams(), lab, torque_n_m=0.0)  # the session's own
    for torque_n_m in (0.0, 0.2):
        declared = replace(turns, max_torque=torque_n_m)
        assert not warned(declared, MasterParams(), lab)
        limited = limits_of(declared, SafetyParams(), 0.05).max_torque
        assert limited == min(torque_n_m, SafetyParams.max_force * 0.05)
    assert not warned(turns, MasterParams(), DeviceParams())  # simulated
    assert not warned(info(), MasterParams(), lab)


def test_a_light_device_is_warned_of_before_it_hums():
    light, known = info(apparent_mass=0.02), DeviceParams(mass=0.02)
    (text,) = warned(light, MasterParams(), known)
    assert text.startswith("b T_c/m = 1.25 on this device (25 N s/m, 1 ms, 0.02 kg)")
    assert "overshoots" in text and "master.impedance < 20 N s/m" in text
    heavy = MasterParams(impedance=50.0)
    (text,) = warned(light, heavy, known)
    assert "is unstable" in text
    assert not warned(light, heavy, known, waves=False, strict=False)


def test_a_device_unlike_the_one_predictions_rest_on_is_named():
    other = info(apparent_mass=0.5, apparent_damping=2.0, workspace_m=0.08)
    mass, damping, workspace = warned(other, MasterParams(), DeviceParams())
    assert mass.startswith("device.mass = 0.25 kg, the device declares 0.5 kg")
    assert damping.startswith("device.damping = 0 N s/m, the device declares 2 N s/m")
    assert "set device.workspace_m = 0.08" in workspace
    fitting = DeviceParams(mass=0.5, damping=2.0, workspace_m=0.08)
    assert not warned(other, MasterParams(), fitting)


def test_a_device_behind_counts_is_warned_of_with_its_own_mass_and_count():
    coarse = info(apparent_mass=0.1, encoder_step_m=1e-4, velocity="estimated")
    known = DeviceParams(mass=0.1, encoder_step_m=1e-4)
    (text,) = warned(coarse, MasterParams(), known)
    assert text.startswith("velocities are differences of counts of 100 um: b = 25 N s/m, b h/m")
    assert "b h/m = 0.25 " in text and "known up to master.impedance = 15 N s/m" in text
    (mass, other) = warned(coarse, MasterParams(), DeviceParams(mass=0.1))
    assert mass == text and "the device declares 0.0001 m" in other
    small = MasterParams(impedance=15.0)
    (text,) = warned(coarse, small, known)
    assert "at most 0.1 b q^2/h = 0.015 mJ" in text
    assert not warned(coarse, small, known, strict=False)
    assert not warned(info(apparent_mass=0.1, encoder_step_m=1e-4), small, known)
