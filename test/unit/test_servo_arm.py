# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An arm of servos behind a bus, on a pseudo terminal: what the device ``lerobot`` writes reaches
the motors, what they measure comes back, and a bus that fails ends both.
"""

import contextlib
import math
import time

import numpy as np
import pytest
from support.servo_bus import ServoArm, ServoLeader, frame, taken
from support.vendor_setup import whole

from pmwvc_core.errors import DeviceError
from pmwvc_master.devices import lerobot
from pmwvc_master.devices.lerobot import LerobotDevice, LerobotParams

PATIENCE_S = 30.0
PROFILE = """
joints:
  source: drawing
  value:
  - [shoulder, 0.2, 0, 0, 0, 0.017453292519943295]
  - [elbow, 0.1, 0, 0, 0, 0.017453292519943295]
workspace_m: {value: 0.3, source: sum of the links}
"""
LENGTHS = 0.2, 0.1


@pytest.fixture
def arm(monkeypatch, tmp_path):
    """Servos at 90 and -90 degrees, and what opens the device at them."""
    monkeypatch.setattr(lerobot, "PAUSE_S", 0.001)
    file = tmp_path / "arm.yaml"
    file.write_text(PROFILE)
    with contextlib.ExitStack() as ends:
        servos = ServoArm((math.pi / 2, -math.pi / 2))
        ends.callback(servos.close)

        def opened(**device):
            params = LerobotParams(
                model=str(file), teleoperator=f"{ServoLeader.__module__}:{ServoLeader.__name__}",
                config=f"port={servos.port}",
            )  # fmt: skip
            made = whole(LerobotDevice, params, "lerobot", 2, **device)
            ends.callback(made.close)
            made.open()
            return made

        yield servos, opened


def until(there):
    end = time.monotonic() + PATIENCE_S
    while not there():
        assert time.monotonic() < end
        time.sleep(0.001)


def hand(servos):
    """Return where the hand is, by the closed form of two links."""
    one, two = servos.angle[1], servos.angle[1] + servos.angle[2]
    (a, b) = LENGTHS
    at = [a * math.cos(one) + b * math.cos(two), a * math.sin(one) + b * math.sin(two)]
    return np.array(at)


def test_a_force_turns_the_motors_the_hand_gives_way_and_its_work_is_that_of_the_motors(arm):
    servos, opened = arm
    device = opened()
    np.testing.assert_allclose(device.read(time.monotonic_ns()).x, hand(servos), atol=1e-3)
    begin, force = hand(servos), np.array([0.4, 0.3])
    work_j, before = 0.0, None

    def gave_way():
        nonlocal work_j, before
        sample = device.read(time.monotonic_ns())
        if sample.fresh:
            work_j += 0.0 if before is None else float(force @ (sample.x - before))
            before = sample.x
        device.write(-force)
        return np.linalg.norm(sample.x - begin) > 0.04

    until(gave_way)
    assert force @ (hand(servos) - begin) > 0.0
    assert work_j == pytest.approx(servos.work_j, rel=0.3)
    device.stop()
    until(lambda: not any(servos.torque.values()))


def test_a_bus_that_falls_silent_or_garbles_makes_samples_invalid_until_it_speaks_again(arm):
    servos, opened = arm
    device = opened()

    def valid():
        device.write(np.zeros(2))
        return device.read(time.monotonic_ns()).valid

    for fault in ("mute", "broken"):
        setattr(servos, fault, True)
        until(lambda: not valid())
        setattr(servos, fault, False)
        until(valid)


def test_two_masters_on_one_bus_are_refused_by_its_port_and_no_arm_is_named(arm):
    servos, opened = arm
    opened()
    with pytest.raises(DeviceError, match=rf"lerobot: device {servos.port}: another master has"):
        opened()


def test_an_arm_that_never_answers_is_refused_when_opened(arm):
    servos, opened = arm
    servos.mute = True
    with pytest.raises(
        DeviceError, match=r"cannot be opened: ConnectionError: no answer of servo"
    ):
        opened()


def test_a_frame_is_known_by_marks_length_and_checksum():
    sent = frame(2, 3, b"\x2c\x01\x00")
    assert taken(b"\x00" + sent + b"rest") == ((2, 3, b"\x2c\x01\x00"), b"rest")
    assert taken(sent[:-1])[0] is None
    assert taken(sent[:-1] + bytes([sent[-1] ^ 1])) == (None, b"")
