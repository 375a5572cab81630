# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The Touch against a fake of the vendor's library, whose thread calls back."""

import contextlib
import math
import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.fake_library import FakeLibrary, compiled, needs_compiler
from support.vendor_setup import whole

from pmwvc_core.errors import DeviceError
from pmwvc_core.frame import STALE_NS
from pmwvc_master.devices.touch import TouchDevice, TouchParams

pytestmark = needs_compiler
PATIENCE_S = 30.0


def made(dof=1, *, clutch=0, **params):
    return whole(TouchDevice, TouchParams(**params), "touch", dof, clutch=clutch)


@pytest.fixture
def fake(tmp_path):
    """A library of its own for each test."""
    with contextlib.closing(
        FakeLibrary(compiled(tmp_path, "fake_hd.c", "libHD.so"), made)
    ) as library:
        yield library


def until(there):
    """Wait until something is so."""
    end = time.monotonic() + PATIENCE_S
    while not there():
        assert time.monotonic() < end
        time.sleep(0.001)


def pushed(device, f_m, there):
    """Push, as a loop that does not stall, until something is so."""
    until(lambda: device.write(f_m) or there())


def newest(fake, device):
    """Return a sample that was measured after now, in the library's thread."""
    frames = fake["frames"]
    until(lambda: fake["frames"] >= frames + 2)
    return device.read(time.monotonic_ns())


def test_one_axis_is_the_devices_x_in_metres(fake):
    device = fake.opened()
    sample = newest(fake, device)
    assert (sample.x, sample.xd, sample.valid) == (0.01, 0.1, True)
    age_ns = time.monotonic_ns() - sample.measured_ns
    assert 0 <= age_ns < 10 * STALE_NS
    pushed(device, 1.5, lambda: list(fake.vector("force")) == [-1.5, 0.0, 0.0])


def test_a_button_uncouples_the_hand(fake):
    device = fake.opened(clutch=2)
    for mask, uncoupled in ((1, False), (2, True)):
        fake["buttons"] = mask
        newest(fake, device)
        device.write(0.0)
        assert device.uncoupled is uncoupled


def test_three_axes_are_right_forwards_and_up_for_motion_and_force(fake):
    device = fake.opened(3)
    sample, f_m = newest(fake, device), np.array([1.0, -2.0, 0.5])
    np.testing.assert_allclose(sample.x, [0.01, -0.03, 0.02])
    np.testing.assert_allclose(sample.xd, [0.1, -0.4, 0.2])
    pushed(device, f_m, lambda: any(fake.vector("force")))
    work = 1e-3 * np.dot(fake.vector("force"), fake.vector("velocity"))
    assert work == pytest.approx(-f_m @ sample.xd)


def test_a_sample_is_new_once_and_invalid_when_the_thread_stalls(fake):
    device = fake.opened()
    assert newest(fake, device).fresh
    fake["stalled"] = 1
    until(lambda: not device.read(time.monotonic_ns()).fresh)
    at_ns = device.read(0).measured_ns
    assert device.read(at_ns + STALE_NS).valid
    assert not device.read(at_ns + STALE_NS + 1).valid
    fake["stalled"] = 0
    until(lambda: device.read(time.monotonic_ns()).fresh)
    assert device.read(time.monotonic_ns()).valid


def test_a_loop_that_stalls_pushes_nobody(fake):
    device = fake.opened()
    for _ in range(2):
        pushed(device, 2.0, lambda: fake.vector("force")[0] == -2.0)
        until(lambda: fake.vector("force")[0] == 0.0)  # nobody writes


def test_an_error_of_the_library_makes_a_sample_invalid(fake):
    device = fake.opened()

    def valid_with(code):
        fake["code"] = code
        return device.read(time.monotonic_ns()).valid

    until(lambda: not valid_with(0x0200))  # warm motors
    until(lambda: valid_with(0))
    fake.vector("position")[0] = math.nan
    until(lambda: not device.read(time.monotonic_ns()).valid)
    fake.vector("position")[0] = 3000.0
    until(lambda: not device.read(time.monotonic_ns()).valid)


def test_errors_at_once_cost_one_sample(fake):
    """Ten on the library's stack, taken off one by one, made ten samples invalid."""
    fake.opened()
    fake["copies"], frames = 10, fake["frames"]
    fake["code"] = 0x0200
    until(lambda: not fake["code"])
    assert fake["frames"] - frames < 8


def test_forces_are_off_at_the_end_whatever_comes_after(fake):
    device = fake.opened()
    assert fake["enabled"] == 1
    device.write(1.0)
    device.stop()
    until(lambda: not any(fake.vector("force")))
    for _ in range(2):
        device.close()
        assert (fake["enabled"], fake["open"]) == (0, 0)
    device.stop()
    device.write(1.0)
    assert fake.opened().read(time.monotonic_ns()).valid


@pytest.mark.parametrize(
    ("state", "params", "text"),
    [
        (
            {"busy": 1},
            {},
            r"touch\.device = '': cannot be opened \(0x0302 b'communication error'\)",
        ),
        ({}, {"device": "left"}, r"touch\.device = 'left': cannot be opened"),
        ({}, {"serial": "S-2"}, r"touch\.serial = S-2: the device is Touch, serial number S-1"),
        ({}, {"model": "omni"}, r"model = 'omni': the device is Touch, .*; set its model"),
        (
            {},
            {"model": "touch_x"},
            r"model = 'touch_x': the library gives 3\.3 N for a Touch",
        ),
        ({"calibration": 0x5002}, {}, "is not calibrated; put the pen into its rest"),
        ({"stalled": 1}, {}, "no measurement in 0.2 s"),
    ],
)
def test_what_cannot_be_opened_is_refused_with_the_remedy(fake, monkeypatch, state, params, text):
    monkeypatch.setattr("pmwvc_master.devices.vendor.OPEN_S", 0.2)
    usual = {name: fake[name] for name in state}
    for name, given in state.items():
        fake[name] = given
    with pytest.raises(DeviceError, match=text):
        fake.opened(**params)
    assert (fake["open"], fake["enabled"]) == (0, 0)
    for name, given in usual.items():
        fake[name] = given
    assert fake.opened(serial="S-1").read(time.monotonic_ns()).valid


def test_a_calibration_that_the_library_can_do_is_done(fake):
    fake["calibration"] = 0x5001
    fake.opened()
    assert fake["updated"] == 1


def test_two_devices_are_told_apart_by_name_and_serial_number(fake, tmp_path):
    fake.text("name", "left")
    left = fake.opened(device="left", serial="S-1")
    folder = tmp_path / "second"
    folder.mkdir()
    other = FakeLibrary(compiled(folder, "fake_hd.c", "libHD.so"), made)
    with pytest.raises(DeviceError, match="touch: device S-1: another master has it"):
        other.opened()
    other.close()
    other.text("serial", "S-9")
    with contextlib.closing(other):
        right = other.opened()
        other.vector("position")[0] = -50.0
        until(lambda: right.read(time.monotonic_ns()).x == -0.05)
        assert left.read(time.monotonic_ns()).x == 0.01
        pushed(right, 1.0, lambda: other.vector("force")[0] == -1.0)
        assert fake.vector("force")[0] == 0.0


def test_a_library_that_lacks_a_call_or_is_not_there_is_named(tmp_path):
    path = compiled(tmp_path, "fake_hd.c", "libHD.so", "-DLACKS")
    with pytest.raises(DeviceError, match=r"libHD\.so': lacks hdStopScheduler; install a newer"):
        made(library=str(path)).open()
    with pytest.raises(DeviceError, match=r"touch\.library = '': .*install the OpenHaptics SDK"):
        made().open()


def test_with_six_axes_the_pen_turns_the_handle_and_nothing_pushes_the_turn(fake, monkeypatch):
    """About the device's y, which is up: the world's z. It is said at the start."""
    told, angle = [], 0.3
    monkeypatch.setattr(TouchDevice, "_tell", lambda _, text: told.append(text))
    device = fake.opened(6)
    assert any("no torque: a hand gives turns, and feels none" in text for text in told)
    assert newest(fake, device).orientation == (0.0, 0.0, 0.0, 1.0)
    fake["stalled"], transform = 1, fake.vector("transform", 16)
    time.sleep(0.01)
    columns = Rotation.from_rotvec([0.0, angle, 0.0]).as_matrix().T
    for axis, column in enumerate(columns.tolist()):
        transform[4 * axis : 4 * axis + 3] = column
    fake["stalled"] = 0
    sample = newest(fake, device)
    np.testing.assert_allclose(sample.x, [0.01, -0.03, 0.02, 0.0, 0.0, 0.05 * angle], atol=1e-12)
    half = [0.0, 0.0, math.sin(0.5 * angle), math.cos(0.5 * angle)]
    np.testing.assert_allclose(sample.orientation, half, atol=1e-12)
    assert not newest(fake, device).xd[3:].any()  # it is at rest again
    asked = np.array([1.0, 0.0, 0.0, 0.5, 0.5, 0.5])
    pushed(device, asked, lambda: list(fake.vector("force")) == [-1.0, 0.0, 0.0])
    transform[0] = math.nan
    assert not newest(fake, device).valid
    assert fake.opened(3).info.dof == 3
