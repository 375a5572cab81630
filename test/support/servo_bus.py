# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An arm of servos on a pseudo terminal, and a Teleoperator that speaks with it, as LeRobot's.

A frame of the bus, both ways, has a checksum over what follows the marks, inverted::

    0xFF 0xFF  id  length of the rest  instruction or error  data  checksum

Position: 4096 counts a turn; torque: thousandths of N m, both 16 bits. A servo has an inertia and
a damper, and goes on by the time of the bus.
"""

import dataclasses
import os
import select
import struct
import threading
import time
import tty

READ, WRITE, POSITION, TORQUE = 2, 3, 56, 44
COUNTS, PATIENCE_S = 4096, 0.1
INERTIA, DAMPER = 2e-3, 4e-3  # [kg m^2], [N m s]
JOINTS = {"shoulder": 1, "elbow": 2}


def frame(servo, instruction, data=b""):
    body = bytes([servo, len(data) + 2, instruction]) + data
    return b"\xff\xff" + body + bytes([~sum(body) & 0xFF])


def taken(buffer):
    """Return the first whole frame (id, instruction, data) or None, and what follows."""
    start = buffer.find(b"\xff\xff")
    if start < 0 or len(buffer) < start + 4 or len(buffer) < start + 4 + buffer[start + 3]:
        return None, buffer
    end = start + 4 + buffer[start + 3]
    body, rest = buffer[start + 2 : end - 1], buffer[end:]
    right = buffer[end - 1] == ~sum(body) & 0xFF
    return (body[0], body[2], body[3:]) if right else None, rest


class ServoArm:
    """The servos, at the other end of the terminal ``port``; a thread answers."""

    def __init__(self, angles):
        self._bus, self._end = os.openpty()
        for each in (self._bus, self._end):
            tty.setraw(each)
        self.port, self.mute, self.broken = os.ttyname(self._end), False, False
        self.angle = dict(zip(JOINTS.values(), angles, strict=True))
        self.speed, self.torque = dict.fromkeys(self.angle, 0.0), dict.fromkeys(self.angle, 0.0)
        self.work_j, self._open, self._last_s = 0.0, True, time.monotonic()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _go_on(self):
        now_s = time.monotonic()
        while self._last_s < now_s:
            self._last_s += 1e-3
            for servo, torque in self.torque.items():
                push = torque - DAMPER * self.speed[servo]
                self.speed[servo] += 1e-3 * push / INERTIA
                self.angle[servo] += 1e-3 * self.speed[servo]
                self.work_j += 1e-3 * torque * self.speed[servo]

    def _serve(self):
        buffer = b""
        while self._open:
            if not select.select([self._bus], [], [], 0.005)[0]:
                continue
            buffer += os.read(self._bus, 256)
            request, buffer = taken(buffer)
            while request is not None:
                self._answer(*request)
                request, buffer = taken(buffer)

    def _answer(self, servo, instruction, data):
        self._go_on()
        if self.mute:
            return
        answer = b""
        if instruction == READ and data[0] == POSITION:
            counts = round(self.angle[servo] / (2 * 3.141592653589793) * COUNTS)
            answer = struct.pack("<h", counts)
        elif instruction == WRITE and data[0] == TORQUE:
            self.torque[servo] = struct.unpack("<h", data[1:])[0] * 1e-3
        sent = frame(servo, 0, answer)
        os.write(self._bus, sent[:-1] + bytes([sent[-1] ^ self.broken]))

    def close(self):
        self._open = False
        self._thread.join()
        os.close(self._bus)
        os.close(self._end)


@dataclasses.dataclass
class ServoConfig:
    port: str = ""
    id: str = ""


class ServoLeader:
    """A Teleoperator with two joints, in degrees."""

    config_class, is_calibrated = ServoConfig, True

    def __init__(self, config):
        self.feedback_features = {f"{joint}.torque": float for joint in JOINTS}
        self._port, self._file, self._buffer = config.port, -1, b""

    def connect(self, calibrate=True):
        self._file = os.open(self._port, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self._file)

    def _asked(self, servo, instruction, data):
        os.write(self._file, frame(servo, instruction, data))
        until_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < until_s:
            if select.select([self._file], [], [], 0.01)[0]:
                self._buffer += os.read(self._file, 256)
            answer, self._buffer = taken(self._buffer)
            if answer is not None and answer[0] == servo:
                return answer[2]
        raise ConnectionError(f"no answer of servo {servo} at {self._port}")

    def get_action(self):
        counts = {
            joint: struct.unpack("<h", self._asked(servo, READ, bytes([POSITION, 2])))[0]
            for joint, servo in JOINTS.items()
        }
        return {f"{joint}.pos": 360.0 * each / COUNTS for joint, each in counts.items()}

    def send_feedback(self, feedback):
        for joint, servo in JOINTS.items():
            torque = struct.pack("<h", round(1e3 * feedback[f"{joint}.torque"]))
            self._asked(servo, WRITE, bytes([TORQUE]) + torque)

    def disconnect(self):
        os.close(self._file)
