# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The Force Dimension device against a fake of the vendor's library, made by the C compiler."""

import contextlib
import math

import numpy as np
import pytest
from rclpy.parameter import Parameter
from scipy.spatial.transform import Rotation
from support.fake_library import FakeLibrary, compiled, needs_compiler
from support.peers import ros
from support.vendor_setup import vendor_setup, whole

from pmwvc_core.errors import DeviceError
from pmwvc_master.devices.force_dimension import ForceDimensionDevice, ForceDimensionParams


def made(dof=1, *, clutch=0, **params):
    kind, given = ForceDimensionDevice, ForceDimensionParams(**params)
    return whole(kind, given, "force_dimension", dof, clutch=clutch)


@pytest.fixture
def fake(tmp_path):
    """A library of its own for each test: its variables are as they were."""
    path = compiled(tmp_path, "fake_dhd.c", "libdhd.so.3")
    with contextlib.closing(FakeLibrary(path, made)) as library:
        yield library


@needs_compiler
def test_one_axis_is_the_devices_y_with_the_sign_of_the_world(fake):
    device = fake.opened()
    sample = device.read(0)
    assert (sample.x, sample.xd, sample.valid, sample.fresh) == (0.02, 0.2, True, True)
    device.write(1.5)
    assert list(fake.vector("force")) == [0.0, -1.5, 0.0]


@needs_compiler
def test_a_button_uncouples_the_hand(fake):
    device = fake.opened(clutch=3)
    for mask, uncoupled in ((0b11, False), (0b100, True)):
        fake["buttons"] = mask
        device.read(0)
        device.write(0.0)
        assert device.uncoupled is uncoupled


@needs_compiler
def test_three_axes_are_turned_alike_for_motion_and_force(fake):
    device = fake.opened(3)
    sample, f_m = device.read(0), np.array([1.0, -2.0, 0.5])
    np.testing.assert_allclose(sample.x, [0.02, -0.01, 0.03])
    device.write(f_m)
    assert np.dot(fake.vector("force"), fake.vector("velocity")) == pytest.approx(-f_m @ sample.xd)


@needs_compiler
def test_forces_are_switched_on_at_zero_and_off_at_the_end(fake):
    device = fake.opened()
    assert (fake["enabled"], fake["window_ms"]) == (1, 1)
    assert fake.number("force_when_enabled").value == 0.0
    device.write(3.0)
    for _ in range(2):
        device.stop()
        assert list(fake.vector("force")) == [0.0, 0.0, 0.0]
    device.close()
    assert (fake["enabled"], fake["open"]) == (0, 0)
    device.stop()
    device.close()


@needs_compiler
def test_an_error_makes_a_sample_invalid_and_moves_nothing(fake):
    device = fake.opened()
    assert device.read(0).valid
    fake.vector("position")[1] = 0.05
    fake["result"] = -1
    assert (device.read(0).valid, device.read(0).x) == (False, 0.02)
    fake["result"] = 0
    assert (device.read(0).valid, device.read(0).x) == (True, 0.05)
    for wrong in (math.nan, 50.0):
        fake.vector("position")[1] = wrong
        assert (device.read(0).valid, device.read(0).x) == (False, 0.05)
    fake.vector("position")[1], fake.vector("velocity")[0] = 0.05, math.inf
    assert not device.read(0).valid


@needs_compiler
def test_a_force_that_is_refused_makes_the_next_sample_invalid(fake):
    device = fake.opened()
    fake["force_result"] = -1
    device.write(1.0)
    assert not device.read(0).valid
    fake["force_result"] = 2  # a motor at its limit
    device.write(0.0)
    assert device.read(0).valid


@needs_compiler
def test_a_position_that_is_not_new_is_not_fresh(fake):
    device = fake.opened()
    fake["result"] = 1
    sample = device.read(0)
    assert (sample.valid, sample.fresh) == (True, False)


@needs_compiler
@pytest.mark.parametrize(
    ("state", "params", "text"),
    [
        ({"busy": 1}, {}, r"no device can be opened \(device in use\): plug it in"),
        ({}, {"serial": 8}, r"no serial = 8 can be opened"),
        ({"type": 60}, {}, r"model = 'omega\.3': the device is fake \(type 60\), .*set its model"),
        ({"power": 0}, {}, "not ready; switch it on"),
        ({"calibrated": 0}, {}, "not ready; calibrate it"),
        ({"force_result": -1}, {}, "dhdSetForce failed: device in use"),
    ],
)
def test_what_cannot_be_opened_is_refused_with_the_remedy(fake, state, params, text):
    for name, given in state.items():
        fake[name] = given
    with pytest.raises(DeviceError, match=text):
        fake.opened(**params)
    assert not fake["open"]
    for name in state:
        fake[name] = {"busy": 0, "type": 33, "force_result": 0}.get(name, 1)
    assert fake.opened(serial=77).read(0).valid


@needs_compiler
def test_another_device_than_the_one_asked_for_is_refused_and_one_that_has_a_master(fake):
    fake["reported_serial"] = 78
    with pytest.raises(DeviceError, match=r"serial = 77: the device is fake .* number 78"):
        fake.opened(serial=77)
    fake.opened()
    other = made(library=fake.path)
    with pytest.raises(DeviceError, match="device 78: another master has it"):
        other.open()
    fake.close()
    other.open()
    other.close()


def test_a_library_that_is_not_there_is_named_with_the_remedy(tmp_path):
    params = ForceDimensionParams(library=str(tmp_path / "libdhd.so.3"))
    device = ForceDimensionDevice(vendor_setup("force_dimension"), params)
    with pytest.raises(DeviceError, match=r"library = '.*No such file.*install the Force Dim"):
        device.open()
    device.stop()
    device.close()


def test_limits_are_those_of_the_model_and_parameters_the_nodes():
    given = [Parameter("force_dimension.model", value="falcon")]
    options = {"automatically_declare_parameters_from_overrides": True}
    with ros(parameter_overrides=given, **options) as peer:
        device = ForceDimensionDevice(vendor_setup("force_dimension", 3, node=peer.node))
    assert (device.info.model, device.info.max_force) == ("falcon", 8.0)
    assert (device.info.workspace_m, device.info.dof) == (0.04, 3)
    with pytest.raises(DeviceError, match=r"model = 'omega\.9': must be delta\.3, .*YAML"):
        ForceDimensionDevice(vendor_setup("force_dimension"), ForceDimensionParams("omega.9"))


@needs_compiler
@pytest.mark.parametrize(
    ("model", "type_", "drives"), [("sigma.7", 104, True), ("omega.7", 35, False)]
)
def test_with_six_axes_a_wrist_turns_the_handle_and_an_active_one_gives_its_torque(
    fake, model, type_, drives
):
    """About the device's y, which is the world's x; a torque of the force at the lever."""
    fake["type"] = type_
    device = fake.opened(6, model=model)
    assert device.read(0).orientation == (0.0, 0.0, 0.0, 1.0)
    turn = Rotation.from_rotvec([0.0, 0.02, 0.0]).as_matrix().ravel().tolist()
    fake.vector("frame", 9)[:] = turn
    sample = device.read(1_000_000)
    np.testing.assert_allclose(sample.x, [0.02, -0.01, 0.03, 0.05 * 0.02, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(sample.xd[3:], [0.05 * 20.0, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(sample.orientation[:3], [math.sin(0.01), 0.0, 0.0], atol=1e-12)
    device.write(np.array([1.0, 0.0, 0.0, 2.0, 0.0, 0.0]))
    assert list(fake.vector("force")) == [0.0, -1.0, 0.0]
    np.testing.assert_allclose(fake.vector("torque"), [0.0, -0.05 * 2.0 * drives, 0.0])
    fake.vector("frame", 9)[0] = math.nan
    assert not device.read(2_000_000).valid


def test_a_model_without_a_wrist_has_three_axes():
    setup = vendor_setup("force_dimension", 6)
    models = {"omega.3": 3, "falcon": 3, "omega.6": 6, "delta.6": 6}
    found = {m: ForceDimensionDevice(setup, ForceDimensionParams(m)).info.dof for m in models}
    assert found == models
