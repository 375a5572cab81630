# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The Haply device at an Inverse Service that goes, is another, or has other devices."""

import contextlib
import math
import socket
import threading
import time

import numpy as np
import pytest
from rclpy.parameter import Parameter
from scipy.spatial.transform import Rotation
from support.haply_rig import exchanged, let_wait, opened
from support.inverse_service import InverseService
from support.loop_rig import TICK_NS
from support.peers import ros
from support.vendor_setup import vendor_setup, whole

from pmwvc_core.errors import DeviceError
from pmwvc_master.devices import haply
from pmwvc_master.devices.haply import CALL_NS, HaplyDevice, HaplyParams
from pmwvc_master.devices.mapped import make_device


@pytest.fixture
def waiting(monkeypatch):
    """Reads wait for an answer."""
    let_wait(monkeypatch)


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


def test_a_connection_is_closed_when_its_last_force_has_been_answered():
    with InverseService() as service, opened(service) as device:
        service.hold()
        device.read(time.monotonic_ns())
        device.write(1.0)
        device.stop()
        closing = threading.Thread(target=device.close)
        closing.start()
        assert [service.force()[1]["x"] for _ in range(2)] == [-1.0, 0.0]
        service.release(1)
        assert closing.is_alive() and device._link is not None
        service.release()
        closing.join()
        assert device._link is None


def test_a_connection_of_a_service_that_is_silent_is_closed_after_a_second():
    with InverseService() as service, opened(service) as device:
        service.hold()
        device.read(begun_ns := time.monotonic_ns())
        device.stop()
        device.close()
        assert time.monotonic_ns() - begun_ns > CALL_NS


def until(device, due_ns, there):
    """Read, at one moment, until something has come."""
    for _ in range(10**6):
        device.read(due_ns)
        if there():
            return
    raise AssertionError("nothing came")


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
    device = whole(HaplyDevice, HaplyParams(service=service.url, **params), "haply")
    with pytest.raises(DeviceError, match=match):
        device.open()
    device.close()


def test_what_cannot_be_opened_is_refused_with_the_remedy():
    with InverseService() as service:
        with opened(service):
            refused(service, "haply: device 049D: another master has it")
        with opened(service):  # given back
            pass
        refused(service, r"device_id = '04A1': must be one of 049D", device_id="04A1")
        refused(
            service,
            r"model = 'minverse': the device is inverse3, .* set its model",
            model="minverse",
        )
        service.position = [0.0, -120.0, 150.0]
        refused(service, r"position \(0, -119\.9, 149\.8\) m from the middle, .*are these mm\?")
        service.position, service.status = [0.0, 0.0, 0.0], {"calibrated": False}
        refused(service, "not calibrated")
        service.ids = ("049D", "04A1")
        refused(service, r"device_id = '': must be one of 049D, 04A1")
        service.ids = ()
        refused(service, "one of none; plug it in")
    with serving(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n", service.port):
        refused(service, "no WebSocket: .*404; start the Haply Hub")
    refused(service, r"haply\.service = 'ws://127.*refused; start the Haply Hub")
    with pytest.raises(DeviceError, match="has 3 axes; set dof = 4 to 3 or less"):
        make_device("haply", vendor_setup("haply", 4))


def test_a_snapshot_of_wrong_types_is_no_inverse_service(monkeypatch):
    """Its errors ended the node, or its loop where the service was called again."""
    with InverseService() as service:
        for answer in ('{"inverse3": [{"device_id": "049D", "config": "x"}]}', "[" * 100_000):
            monkeypatch.setattr(service, "answer", lambda config, answer=answer: answer)
            refused(service, "what answers is no Inverse Service; start")
    refused(
        type("Named", (), {"url": f"ws://{'a' * 80}:1"}), r"label too long\); start the Haply Hub"
    )


def node_of(service, **given):
    """Join as a node that was given parameters of the device."""
    given = {f"haply.{name}": value for name, value in (given | {"service": service.url}).items()}
    return ros(
        parameter_overrides=[Parameter(name, value=value) for name, value in given.items()],
        automatically_declare_parameters_from_overrides=True,
    )


def test_parameters_are_the_nodes_and_the_services_settings_are_told(monkeypatch):
    with InverseService() as service, node_of(service, device_id="049D") as peer:
        said = []
        monkeypatch.setattr(HaplyDevice, "_tell", lambda _, text: said.append(text))
        device = HaplyDevice(vendor_setup("haply", node=peer.node))
        assert device._params == HaplyParams(service=service.url, device_id="049D")
        device.open()
        device.close()
        text = " ".join(said)
        assert "049D, forces as 'vector'" in text
        assert "max_force_n = 10.0 (chai3d_haply)" in text
        assert '"force_gate": {"gain": 0.3}' in text and "gravity_compensation" in text
    with pytest.raises(DeviceError, match=r"must be inverse3, minverse or a YAML"):
        HaplyDevice(vendor_setup("haply"), HaplyParams(model="inverse4"))


def grip(rotvec):
    q = Rotation.from_rotvec(rotvec).as_quat().tolist()
    return {"state": {"orientation": dict(zip("xyzw", q, strict=True)), "buttons": {"b": True}}}


@pytest.mark.parametrize("version", ["3.5", "3.1"])
def test_with_six_axes_the_grip_turns_the_handle_and_only_forces_are_sent(monkeypatch, version):
    let_wait(monkeypatch)
    with InverseService(version=version) as service:
        service.grips = [grip([0.0, 0.0, 0.0])]
        with opened(service, dof=6) as device:
            assert device.info.dof == 6
            service.grips = [grip([0.0, 0.0, 0.02])]
            force, sample = exchanged(service, device, np.array([1.0, 0.0, 0.0, 0.5, 0.5, 0.5]))
            assert force == {"x": -1.0, "y": 0.0, "z": 0.0}
            np.testing.assert_allclose(sample.x[3:], [0.0, 0.0, 0.05 * 0.02], atol=1e-12)
            np.testing.assert_allclose(sample.orientation[2], math.sin(0.01), atol=1e-12)
            service.grips = []
            assert not exchanged(service, device, np.zeros(6), tick=2)[1].valid


def test_six_axes_without_a_grip_are_refused(monkeypatch):
    let_wait(monkeypatch)
    with InverseService() as service:
        with pytest.raises(DeviceError, match="no position or turn of a grip"):
            with opened(service, dof=6):
                pass
        with opened(service, dof=3) as device:
            assert device.info.dof == 3
