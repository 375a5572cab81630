# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The Haply device against a fake Inverse Service, which is late, silent, gone or wrong.

Time is that of the ticks, which the test says; a read waits for the service as long as the test
lets it, or not at all.
"""

import contextlib
import math
import socket
import threading

import numpy as np
import pytest
from rclpy.parameter import Parameter
from support.inverse_service import InverseService
from support.loop_rig import TICK_NS, TICKS, Rig
from support.processes import ros
from support.vendor_setup import vendor_setup

from pmwvc_core.errors import DeviceError, ParameterError
from pmwvc_core.frame import STALE_NS
from pmwvc_core.master.safety import SafetyState
from pmwvc_master.devices import haply, inverse_link
from pmwvc_master.devices.haply import CALL_NS, HaplyDevice, HaplyParams

FOREVER_NS = -60 * 10**9  # a clock that is never due: reads wait until an answer has come


@pytest.fixture
def waiting(monkeypatch):
    """Reads wait for an answer."""
    monkeypatch.setattr(haply, "monotonic_ns", lambda: FOREVER_NS)


@contextlib.contextmanager
def opened(service, *, dof=1, **params):
    device = HaplyDevice(vendor_setup("haply", dof), HaplyParams(service=service.url, **params))
    try:
        device.open()
        assert service.force()[1] == {"x": 0.0, "y": 0.0, "z": 0.0}
        yield device
        device.stop()
    finally:
        device.close()


def exchanged(service, device, f_m, tick=1):
    """Return the force that came for a tick's, then the sample of the next tick."""
    device.read(tick * TICK_NS)
    device.write(f_m)
    force = service.force()[1]
    return force, device.read((tick + 1) * TICK_NS)


@pytest.mark.parametrize("version", ["3.5", "3.1"])
@pytest.mark.parametrize(("axes", "axis", "sign"), [("x y z", "x", 1.0), ("-z x y", "z", -1.0)])
def test_one_axis_pushes_the_hand_against_the_controllers_force(
    waiting, version, axes, axis, sign
):
    with InverseService(version=version) as service, opened(service, axes=axes) as device:
        at = "xyz".index(axis)
        service.position[at] += 0.02
        service.velocity[at] = 0.3
        force, sample = exchanged(service, device, 1.5)
        assert force == {"x": 0.0, "y": 0.0, "z": 0.0} | {axis: -sign * 1.5}
        assert (sample.x, sample.xd) == (pytest.approx(sign * 0.02), pytest.approx(sign * 0.3))
        assert type(sample.x) is float and sample.valid and sample.fresh


def test_three_axes_are_turned_alike_for_motion_and_force(waiting):
    """Work on the hand is the same in both frames."""
    with InverseService() as service, opened(service, dof=3, axes="y -x z") as device:
        moved = np.array([0.01, -0.02, 0.03])
        service.position = (np.array(service.position) + moved).tolist()
        service.velocity = [0.1, 0.2, 0.4]
        f_m = np.array([1.0, -2.0, 0.5])
        force, sample = exchanged(service, device, f_m)
        np.testing.assert_allclose(sample.x, [-0.02, -0.01, 0.03], atol=1e-12)
        np.testing.assert_allclose(sample.xd, [0.2, -0.1, 0.4])
        of_device = np.array([force[axis] for axis in "xyz"]) @ service.velocity
        assert of_device == pytest.approx(-f_m @ sample.xd)


def test_a_sample_is_as_old_as_the_message_it_answers(waiting):
    with InverseService() as service, opened(service) as device:
        for tick in range(1, 5):
            _, sample = exchanged(service, device, 0.0, tick)
            assert (sample.fresh, sample.measured_ns) == (True, tick * TICK_NS)


@pytest.mark.parametrize(("ratio", "grows"), [(0.95, False), (1.05, True)])
def test_a_damping_on_a_state_a_tick_old_is_unstable_from_one(waiting, ratio, grows):
    """b T/m on a free mass, whose velocity the service reports as a message comes."""
    with InverseService() as service, opened(service) as device:
        xd, seen, tick_s, mass = 0.1, 0.0, 0.001, 0.2
        speeds = []
        for tick in range(1, 200):
            service.velocity[0] = xd
            force, sample = exchanged(service, device, ratio * mass / tick_s * seen, tick)
            seen, xd = sample.xd, xd + force["x"] / mass * tick_s
            speeds.append(abs(xd))
        assert (max(speeds[-10:]) > 0.1) == grows


def test_of_answers_that_wait_the_newest_counts_with_its_age(waiting):
    with InverseService() as service, opened(service) as device:
        service.hold()
        for tick in range(1, 5):
            device._due_ns = tick * TICK_NS
            service.position[0] = 0.01 * tick
            device.write(0.0)
            service.force()
        service.release(1)
        first = device.read(5 * TICK_NS)
        assert (first.x, first.measured_ns, first.fresh) == (0.01, TICK_NS, True)
        service.release()
        last = device.read(6 * TICK_NS)
        assert (last.x, last.measured_ns, last.fresh) == (0.04, 4 * TICK_NS, True)
        assert not device.read(7 * TICK_NS).fresh  # nothing more was asked


def test_a_read_takes_all_that_waits_in_however_small_pieces(waiting, monkeypatch):
    monkeypatch.setattr(inverse_link, "READ", 7)
    with InverseService() as service, opened(service) as device:
        service.hold()
        for tick in range(1, 4):
            device._due_ns = tick * TICK_NS
            device.write(0.0)
            service.force()
        service.release()
        assert device.read(4 * TICK_NS).measured_ns == 3 * TICK_NS


def test_answers_that_are_repeated_make_no_sample_younger(waiting):
    with InverseService() as service, opened(service) as device:
        service.copies = 3
        _, sample = exchanged(service, device, 0.0, 1)
        assert sample.measured_ns == TICK_NS
        while (sample := device.read(2 * TICK_NS)).fresh:
            pass
        assert sample.measured_ns == TICK_NS


def test_a_read_waits_half_a_tick_at_most(monkeypatch):
    with InverseService() as service, opened(service) as device:
        service.hold()
        device.read(TICK_NS)
        device.write(0.0)
        service.force()
        waits, select = [], inverse_link.select.select
        monkeypatch.setattr(
            inverse_link.select, "select",
            lambda *of: (waits.append(of[-1]), select(*of[:-1], 0.0))[1],
        )  # fmt: skip
        for now_ns in (2 * TICK_NS, 2 * TICK_NS + 200_000, 9 * TICK_NS):
            monkeypatch.setattr(haply, "monotonic_ns", lambda now_ns=now_ns: now_ns)
            assert not device.read(2 * TICK_NS).fresh
        assert waits == pytest.approx([0.0005, 0.0003, 0.0])


def test_silence_makes_samples_invalid_and_then_ends_the_connection():
    with InverseService() as service, opened(service) as device:
        service.hold()
        device.read(0)
        device.write(0.0)
        service.force()
        assert device.read(STALE_NS).valid
        assert not device.read(STALE_NS + TICK_NS).valid
        assert device.read(CALL_NS).valid is False and device._link is not None
        device.read(CALL_NS + TICK_NS)
        assert device._link is None


@pytest.mark.parametrize("wrong", [[120.0, -0.12, 0.15], [math.nan, 0.0, 0.0]])
def test_a_state_that_cannot_be_is_invalid_and_moves_nothing(waiting, wrong):
    with InverseService() as service, opened(service) as device:
        _, sample = exchanged(service, device, 0.0)
        before = sample.x
        service.position = wrong
        _, sample = exchanged(service, device, 0.0, 2)
        assert (sample.valid, sample.x) == (False, before)
        service.position, service.status = [0.0, 0.0, 0.0], {"calibrated": False}
        assert not exchanged(service, device, 0.0, 3)[1].valid
        service.status = {}
        assert exchanged(service, device, 0.0, 4)[1].valid


def test_stop_sends_zero_force(waiting):
    with InverseService() as service, opened(service) as device:
        assert exchanged(service, device, 2.0)[0]["x"] == -2.0
        device.stop()
        assert service.force()[1] == {"x": 0.0, "y": 0.0, "z": 0.0}


def test_a_service_that_went_away_is_called_every_second(waiting, monkeypatch):
    with InverseService() as service, opened(service) as device:
        exchanged(service, device, 1.0)
        service.stop()
        calls = []
        made = haply.InverseLink
        monkeypatch.setattr(haply, "InverseLink", lambda *of: (calls.append(1), made(*of))[1])
        lost = None
        for tick in range(2, 3000):
            sample = device.read(tick * TICK_NS)
            device.write(1.0)
            lost = lost or (not sample.valid and tick)
        assert lost and len(calls) == (3000 - 1 - lost) // 1000
        service.start()
        until(device, CALL_NS * 5, lambda: device._form)
        assert not device._sample.valid
        force, sample = exchanged(service, device, 0.0, 5000)
        assert force["x"] == 0.0 and sample.valid and service.forces.empty()


def test_a_call_that_nobody_answers_ends_after_a_second():
    with InverseService() as service, opened(service) as device:
        service.stop()
        with socket.create_server(("127.0.0.1", service.port)):
            while device._link is not None:
                device.read(TICK_NS)
            assert device.read(TICK_NS + CALL_NS).valid is False and device._link is not None
            device.read(2 * CALL_NS)
            assert device._link is not None
            device.read(TICK_NS + 2 * CALL_NS)
            assert device._link is None
        service.start()


def until(device, due_ns, there):
    """Read, at one moment, until something has come."""
    for _ in range(10**6):
        device.read(due_ns)
        if there():
            return
    raise AssertionError("nothing came")


def frame(rig, grid):
    if grid % TICKS == 4:
        rig.answer(-0.7)
    rig.tick(grid)


def test_after_a_service_went_away_the_force_rises_from_zero_once_re_armed(waiting):
    with InverseService() as service, opened(service) as device:
        rig = Rig()
        rig.loop.device = device
        for grid in range(800):
            frame(rig, grid)
        before = [service.force()[1]["x"] for _ in range(800)]
        assert before[-1] < -1.0
        service.stop()
        for grid in range(800, 1790):
            frame(rig, grid)
        assert rig.loop.protocol.state == SafetyState.DAMPING
        for grid in range(1790, 2000):
            frame(rig, grid)
        assert rig.loop.protocol.state == SafetyState.FAULT
        while not service.forces.empty():  # sent before the loss was known
            service.force()
        service.start()
        until(device, 2999 * TICK_NS, lambda: device._form)
        for grid in range(3000, 3200):
            frame(rig, grid)
        assert {service.force()[1]["x"] for _ in range(200)} == {0.0}
        assert rig.loop.protocol.state == SafetyState.FAULT
        rig.loop.protocol.rearm()
        for grid in range(3200, 4200):
            frame(rig, grid)
        after = [service.force()[1]["x"] for _ in range(1000)]
        steps = np.abs(np.diff(after))
        assert abs(after[0]) < 0.02 and after[-1] == pytest.approx(before[-1], rel=1e-6)
        assert steps.max() < 0.05


@contextlib.contextmanager
def serving(answer, port):
    """Answer the first call at a port with something else than a WebSocket."""
    with socket.create_server(("127.0.0.1", port)) as server:

        def serve():
            connection, _ = server.accept()
            with connection:
                connection.recv(1 << 16)
                connection.sendall(answer)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield
        thread.join()


def refused(service, match, **params):
    device = HaplyDevice(vendor_setup("haply"), HaplyParams(service=service.url, **params))
    with pytest.raises(DeviceError, match=match):
        device.open()
    device.close()


def test_what_cannot_be_opened_is_refused_with_the_remedy():
    with InverseService() as service:
        with opened(service):
            refused(service, r"haply\.device_id = '049D': another master has this device")
        with opened(service):  # given back
            pass
        refused(service, r"device_id = '04A1': must be one of 049D", device_id="04A1")
        refused(service, r"model = 'minverse': device 049D is a inverse3; set", model="minverse")
        service.position = [0.0, -120.0, 150.0]
        refused(service, r"position \(0, -120, 150\) m: are these mm\?")
        service.position, service.status = [0.0, 0.0, 0.0], {"calibrated": False}
        refused(service, "not calibrated")
        service.ids = ("049D", "04A1")
        refused(service, r"device_id = '': must be one of 049D, 04A1")
        service.ids = ()
        refused(service, "one of none; plug it in")
    with serving(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n", service.port):
        refused(service, "no WebSocket: .*404; start the Haply Hub")
    refused(service, r"haply\.service = 'ws://127.*refused; start the Haply Hub")
    with pytest.raises(DeviceError, match=r"haply\.service = 'localhost'"):
        HaplyDevice(vendor_setup("haply"), HaplyParams(service="localhost"))
    with pytest.raises(DeviceError, match="has 3 axes; set dof = 4 to 3 or less"):
        HaplyDevice(vendor_setup("haply", 4), HaplyParams())
    for axes in ("x x z", "x y", "xyz", "x y z w"):
        with pytest.raises(DeviceError, match=r"haply\.axes = .*x, y and z once"):
            HaplyDevice(vendor_setup("haply"), HaplyParams(axes=axes))


def test_two_devices_of_one_service_have_a_master_each(waiting):
    with InverseService(ids=("049D", "04A1")) as service:
        with opened(service, device_id="049D") as one, opened(service, device_id="04A1") as two:
            for name, device in (("049D", one), ("04A1", two)):
                device.write(1.0)
                assert service.force() == (name, {"x": -1.0, "y": 0.0, "z": 0.0})


def node_of(service, **given):
    """Join as a node that was given parameters of the device."""
    given = {f"haply.{name}": value for name, value in (given | {"service": service.url}).items()}
    return ros(
        parameter_overrides=[Parameter(name, value=value) for name, value in given.items()],
        automatically_declare_parameters_from_overrides=True,
    )


def test_parameters_are_the_nodes_and_the_services_settings_are_told(monkeypatch):
    with InverseService() as service, node_of(service, axes="z x y") as peer:
        said = []
        monkeypatch.setattr(HaplyDevice, "_tell", lambda _, text: said.append(text))
        device = HaplyDevice(vendor_setup("haply", node=peer.node))
        assert device._params == HaplyParams(service=service.url, axes="z x y")
        device.open()
        device.close()
        text = " ".join(said)
        assert "049D, forces as 'vector', limits from Inverse SDK" in text
        assert '"force_gate": {"gain": 0.3}' in text and "gravity_compensation" in text
    with pytest.raises(ParameterError, match=r"must be one of inverse3, minverse"):
        HaplyParams(model="inverse4")


def test_limits_of_the_model_are_declared():
    device = HaplyDevice(vendor_setup("haply"), HaplyParams())
    assert (device.info.max_force, device.info.workspace_m) == (10.0, 0.1)
    small = HaplyDevice(vendor_setup("haply"), HaplyParams(model="minverse"))
    assert (small.info.max_force, small.info.workspace_m) == (None, 0.04)
