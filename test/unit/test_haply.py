# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The Haply device against a fake Inverse Service: motion, force, age.

Time is that of the ticks, which the test says; a read waits for the service as long as the test
lets it, or not at all.
"""

import contextlib
import math
import threading

import numpy as np
import pytest
from support.haply_rig import exchanged, let_wait, opened
from support.inverse_service import InverseService
from support.loop_rig import TICK_NS
from websockets.exceptions import ConnectionClosed

from pmwvc_core.errors import DeviceError
from pmwvc_core.frame import STALE_NS
from pmwvc_master.devices import haply, inverse_link
from pmwvc_master.devices.haply import CALL_NS


@pytest.fixture
def waiting(monkeypatch):
    """Reads wait for an answer."""
    let_wait(monkeypatch)


@pytest.mark.parametrize("version", ["3.5", "3.1"])
def test_one_axis_pushes_the_hand_against_the_controllers_force(waiting, version):
    with InverseService(version=version) as service, opened(service) as device:
        service.position[0] += 0.02
        service.velocity[0] = 0.3
        force, sample = exchanged(service, device, 1.5)
        assert force == {"x": -1.5, "y": 0.0, "z": 0.0}
        assert (sample.x, sample.xd) == (pytest.approx(0.02), pytest.approx(0.3))
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


def test_of_answers_that_wait_the_newest_counts_with_its_age(waiting):
    with InverseService() as service, opened(service) as device:
        ask_while_held(service, device)
        service.release(1)
        first = device.read(3 * TICK_NS)
        assert (first.x, first.measured_ns, first.fresh) == (0.01, TICK_NS, True)
        device.write(0.0)
        service.force()
        service.release()
        last = device.read(4 * TICK_NS)
        assert (last.x, last.measured_ns, last.fresh) == (0.02, 3 * TICK_NS, True)
        assert not device.read(5 * TICK_NS).fresh  # nothing more was asked


def ask_while_held(service, device):
    """Move and write at the first two ticks, whose answers are held back."""
    service.hold()
    for tick in range(1, 3):
        device.driver._due_ns = tick * TICK_NS
        service.position[0] = 0.01 * tick
        device.write(0.0)
        service.force()


def test_a_service_slower_than_the_loop_gets_fewer_forces_and_samples_stay_young(waiting):
    """It answers two of three ticks; a queue would make samples older by a tick every three."""
    with InverseService() as service, opened(service) as device:
        ask_while_held(service, device)
        sent, ages = 2, []
        for tick in range(3, 303):
            if tick % 3:
                service.release(1)
                sample = device.read(tick * TICK_NS)
                ages.append(tick - sample.measured_ns // TICK_NS)
            before = len(device._asked)
            device.write(0.001 * tick)
            if len(device._asked) > before:
                assert service.force()[1]["x"] == -0.001 * tick  # that of the tick itself
                sent += 1
        assert max(ages) <= 3
        assert 195 <= sent <= 202 and service.forces.empty()
        device.stop()
        assert service.force()[1]["x"] == 0.0


def test_a_read_takes_all_that_waits_in_however_small_pieces(waiting, monkeypatch):
    monkeypatch.setattr(inverse_link, "READ", 7)
    with InverseService() as service, opened(service) as device:
        ask_while_held(service, device)
        service.release()
        assert device.read(3 * TICK_NS).measured_ns == 2 * TICK_NS


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
        assert device.read(CALL_NS - TICK_NS).valid is False and device._link is not None
        device.read(CALL_NS)
        assert device._link is None


def test_a_service_that_leaves_messages_without_an_answer_is_called_anew():
    with InverseService() as service, opened(service) as device:
        ask_while_held(service, device)
        service.held.clear()
        assert device.read(2 * TICK_NS).valid
        for due_ns in range(30 * TICK_NS, CALL_NS, 10 * TICK_NS):
            assert not device.read(due_ns).valid and device._link is not None
            device.write(0.0)
        assert service.forces.empty()
        device.read(CALL_NS + TICK_NS)
        assert device._link is None


def test_a_service_that_sends_without_end_blocks_no_loop():
    with InverseService() as service, opened(service) as device:
        ended, connection = threading.Event(), service.connections[-1]

        def send():
            with contextlib.suppress(ConnectionClosed):
                while not ended.is_set():
                    connection.send(service.answer())

        sending = threading.Thread(target=send)
        sending.start()
        for tick in range(20):
            device.read(tick * TICK_NS)
        ended.set()
        while device.driver._link.take():
            pass
        sending.join()


@pytest.mark.parametrize("wrong", [[120.0, -0.12, 0.15], [math.nan, 0.0, 0.0], [10**400, 0, 0]])
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


def test_a_button_of_the_grip_uncouples_the_hand(waiting):
    with InverseService() as service, opened(service, clutch=2) as device:
        exchanged(service, device, 0.0)
        buttons = {"a": True, "b": False, "c": True}
        service.grips = [{"device_id": "9", "state": {"buttons": buttons}}]
        exchanged(service, device, 0.0, 2)
        device.write(0.0)
        assert not device.uncoupled
        buttons["b"] = True
        exchanged(service, device, 0.0, 3)
        device.write(0.0)
        assert device.uncoupled
    refused_clutch = r"clutch = 4: inverse3 has 3 buttons; call ~/clutch instead"
    with pytest.raises(DeviceError, match=refused_clutch), opened(service, clutch=4):
        pass


def test_two_devices_of_one_service_have_a_master_each(waiting):
    with InverseService(ids=("049D", "04A1")) as service:
        with opened(service, device_id="049D") as one, opened(service, device_id="04A1") as two:
            for name, device in (("049D", one), ("04A1", two)):
                device.write(1.0)
                assert service.force() == (name, {"x": -1.0, "y": 0.0, "z": 0.0})
