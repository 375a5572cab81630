# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc devices``: what is there, what is missing, one line each."""

import json

import pytest
from support.command_line import here, refused
from support.inverse_service import InverseService
from support.lab import install, offer

from pmwvc_core.errors import DeviceError
from pmwvc_master.devices import PLUGINS, check, vendor
from pmwvc_master.devices.force_dimension import ForceDimensionDevice
from pmwvc_master.devices.haply import HaplyDevice, HaplyParams


def plug_in(folder, *, vendor="1451", number="7"):
    """Write what the system shows of a USB device."""
    there = folder / "sys" / f"1-{number}"
    there.mkdir(parents=True)
    for name, text in (("idVendor", vendor), ("busnum", "3"), ("devnum", number)):
        (there / name).write_text(f"{text}\n")
    node = folder / "dev" / "003" / number.zfill(3)
    node.parent.mkdir(parents=True, exist_ok=True)
    node.write_text("")
    return node


@pytest.fixture
def usb(monkeypatch, tmp_path):
    monkeypatch.setattr(vendor, "USB", tmp_path / "sys")
    monkeypatch.setattr(vendor, "NODES", tmp_path / "dev")
    return tmp_path


def test_devices_of_a_vendor_are_counted_and_permission_is_asked_for(usb, monkeypatch):
    with pytest.raises(DeviceError, match="no USB device of the vendor 1451: plug it in"):
        vendor.plugged_in("1451")
    plug_in(usb, vendor="2988")
    node = plug_in(usb, number="12")
    assert vendor.plugged_in("1451") == "1 plugged in"
    monkeypatch.setattr(vendor.os, "access", lambda path, _: path != node)
    with pytest.raises(DeviceError, match=r'003/012 may not be opened: make a file .*=="1451"'):
        vendor.plugged_in("1451")
    assert vendor.plugged_in("2988") == "1 plugged in"


def test_a_service_is_listed_with_its_devices(monkeypatch):
    with InverseService(ids=("049D", "04A1")) as service:
        at_it = HaplyParams(service=service.url)
        monkeypatch.setattr("pmwvc_master.devices.haply.HaplyParams", lambda: at_it)
        assert HaplyDevice.look() == "the service has 049D, 04A1"
        service.ids = ()
        assert HaplyDevice.look() == "the service has no device: plug it in and switch it on"
    with pytest.raises(DeviceError, match=r"no Inverse Service at ws://127.*start the Haply Hub"):
        HaplyDevice.look()


def test_a_library_that_is_missing_is_named_with_where_to_get_it():
    with pytest.raises(DeviceError, match="install the Force Dimension SDK"):
        ForceDimensionDevice.look()


def test_every_kind_has_a_line_whatever_is_wrong_with_it(monkeypatch):
    class Fine:
        @staticmethod
        def look():
            return "two on the desk"

    class Missing:
        @staticmethod
        def look():
            raise DeviceError("no cable: buy one")

    found = {"fine": Fine, "missing": Missing, "silent": object}
    offer(monkeypatch, PLUGINS.group, "lab_desk", found, absent="lab_nowhere:Device")
    lines = {line.text.partition(":")[0]: line for line in check.listed()}
    assert lines["fine"] == (True, "fine: two on the desk")
    assert lines["missing"] == (False, "missing: no cable: buy one")
    assert lines["silent"] == (True, "silent: installed")
    assert not lines["absent"].right and "lab_nowhere" in lines["absent"].text


STICK = """
from pmwvc_master.devices import DeviceInfo, DeviceSample

class Stick:
    def __init__(self, setup):
        self.info = DeviceInfo(model="stick", dof=1, max_force=3.0)
        self.sample, self.force = DeviceSample(x=5.0), 0.0
    def open(self): ...
    def read(self, due_ns): return self.sample
    def write(self, f_m): ...
    def couple(self): ...
    def stop(self): ...
    def close(self): ...
"""


def test_the_command_lists_and_refuses_what_cannot_be_checked(tmp_path, monkeypatch):
    install(tmp_path, "lab_stick", STICK, {"pmwvc.devices": 'stick = "lab_stick:Stick"'})
    monkeypatch.syspath_prepend(tmp_path)
    listed = here("devices", "--json", cwd=tmp_path)
    assert listed.returncode == 0
    assert {"right": True, "text": "stick: installed"} in json.loads(listed.stdout)["lines"]
    for words, text in (
        (("check",), "which device? pmwvc devices lists them"),
        (("check", "stick"), "stick: position (5) m from the middle, at most 1 m can be: are"),
        (("check", "stick", "--force", "2"), "--force 2: must be 0..1 N"),
        (("check", "stick", "--set", "dof=2"), "has 1 axes; set dof = 2 to 1 or less"),
        (("check", "glove"), "device.plugin = 'glove': not installed; there are: "),
        (("check", "haply", "--set", "haply.modell=y"), "did you mean haply.model?"),
        (("check", "simulated"), "its hand moves in sessions only; check a device"),
    ):
        assert text in refused(here("devices", *words, cwd=tmp_path))
