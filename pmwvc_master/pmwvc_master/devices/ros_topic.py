# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Devices and simulated hands behind ROS topics: any driver that publishes its pose and takes a
wrench, anybody who publishes the targets of a hand.

PoseStamped, TwistStamped and WrenchStamped (CDR) begin alike::

    0  encapsulation (byte 1: 1 for little endian)    12  length of frame_id with its final 0
    4  stamp         (int32 s, uint32 ns)             16  frame_id

The numbers follow at the next multiple of 8, counted from byte 4. A message object costs 20 us in
Python, this 2 us.
"""

import struct
import time
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import Bool

from pmwvc_core.ends.inbox import value
from pmwvc_core.ends.user_end import Target
from pmwvc_core.errors import DeviceError
from pmwvc_core.numeric import AXES, Value, finite, flatten
from pmwvc_core.quaternions import IDENTITY
from pmwvc_core.runtime.messages import record_of
from pmwvc_core.runtime.topics import RECORDED_QOS, Polled
from pmwvc_master.devices import STALE_NS, DeviceInfo, DeviceSample, DeviceSetup
from pmwvc_master.devices.turn import Turn

# A reliable publisher matches as well.
HAND_QOS = QoSProfile(depth=4, reliability=ReliabilityPolicy.BEST_EFFORT)
_NS_PER_S = 10**9
_ORDER = {0: ">", 1: "<"}
_WRENCH = struct.Struct("<4siII4x6d")  # frame_id "": its final 0, then up to a multiple of 8


def numbers_of(message: bytes, count: int) -> tuple[int, tuple[float, ...]] | None:
    """Return stamp [ns] and the first numbers of a stamped message; None if it is none."""
    if len(message) < 16 or message[1] not in _ORDER:
        return None
    seconds, nanoseconds, length = struct.unpack_from(f"{_ORDER[message[1]]}iII", message, 4)
    begin = 4 + (12 + length + 7) // 8 * 8
    if len(message) < begin + 8 * count:
        return None
    found = struct.unpack_from(f"{_ORDER[message[1]]}{count}d", message, begin)
    return seconds * _NS_PER_S + nanoseconds, found


def wrench(force: Sequence[float], torque: Sequence[float] = (0.0, 0.0, 0.0)) -> bytes:
    """Return a serialized WrenchStamped of now [N], [N m]."""
    stamp = divmod(time.time_ns(), _NS_PER_S)
    return _WRENCH.pack(b"\x00\x01\x00\x00", *stamp, 1, *force, *torque)


def along(message: bytes, dof: int, turn: Turn) -> tuple[int, tuple[float, ...]] | None:
    """Return stamp [ns] and place of a pose along so many axes; None if it is none."""
    pose = numbers_of(message, 7)
    if pose is None or (dof == AXES and not turn.add(pose[1][3:])):
        return None
    return pose[0], (*pose[1][:3], *turn.way.tolist())[:dof]


class Recorded(Polled):
    """A subscription to a hand; the recorder gets what the loop took, and when it did."""

    def __init__(self, node: Node, kind: Any, topic: str) -> None:
        super().__init__(node, kind, topic, HAND_QOS, raw=True)
        self._record = node.create_publisher(kind, record_of(topic), RECORDED_QOS)

    def take(self) -> Any:
        """Return the oldest message not yet taken, or None; never waits."""
        if (message := super().take()) is not None:
            self._record.publish(message)
        return message


class HandTopics:
    """Targets from ``hand/target`` and ``hand/held``, relative to the node's.

    A target holds the handle; age counts from its arrival, so nobody's clock matters.
    ``held: false`` lets go at once, and targets are ignored until ``held: true``; who never
    publishes ``held`` lets go by silence, or with a target that is not finite. Of six axes the
    orientation counts, too: turns since the identity, as of a driver.
    """

    def __init__(self, setup: DeviceSetup) -> None:
        self._dof, self._turn = setup.dof, Turn(setup.lever_m, IDENTITY)
        self._targets = Recorded(setup.node, PoseStamped, "hand/target")
        self._held = Recorded(setup.node, Bool, "hand/held")
        self._open = True  # targets count

    def take(self) -> Sequence[Target]:
        """Return the targets that arrived since the last call; None lets go."""
        found: list[Target] = []
        for message in self._held:
            self._open = any(message[4:5])  # behind the encapsulation
            found += [] if self._open else [None]
        for data in self._targets:
            place = along(data, self._dof, self._turn) if self._open else None
            found += [] if place is None else [value(place[1])]
        return found


class RosTopicDevice:
    """A device that another node drives; its hand's force is not known.

    Relative topics with the names of CRTK: ``device/measured_cp`` (PoseStamped) and, where there
    is one, ``device/measured_cv`` (TwistStamped) in; ``device/servo_cf`` (WrenchStamped) out at
    every tick: the force on the hand, ``-f_m``. Without a twist the velocity is the slope between
    the last two poses, over the difference of their stamps.

    With six axes the pose's orientation counts, too (:mod:`.turn`), and the wrench has a torque.
    A sample holds between messages, so the driver should publish about as fast as the loop runs.
    When no finite pose has come for ``STALE_NS`` the loop renders no force.
    """

    def __init__(self, setup: DeviceSetup) -> None:
        if setup.node is None:
            raise DeviceError("device.plugin = 'ros_topic': needs a ROS node (the master's)")
        self._node, self._dof = setup.node, setup.dof
        if self._dof not in (1, 2, 3, AXES):
            raise DeviceError(f"ros_topic: dof = {self._dof}: must be 1 to 3, or 6")
        self._turn = Turn(setup.lever_m)
        self.info = DeviceInfo("ROS topic device/measured_cp", self._dof, velocity="estimated")
        self._zero = value((0.0,) * setup.dof)
        start = value((setup.start_m, *(0.0,) * (setup.dof - 1)))
        self._sample = DeviceSample(x=start, xd=self._zero, f_h=self._zero, valid=False)
        self._stamp_ns = -2 * STALE_NS  # before any: the first pose gives no velocity
        self._twist_ns: int | None = None

    def open(self) -> None:
        """Make publisher and subscriptions."""
        node, quality = self._node, qos_profile_sensor_data
        self._pose = Polled(node, PoseStamped, "device/measured_cp", quality, raw=True)
        self._twist = Polled(node, TwistStamped, "device/measured_cv", quality, raw=True)
        self._force = node.create_publisher(WrenchStamped, "device/servo_cf", quality)

    def read(self, due_ns: int) -> DeviceSample:
        """Take the samples since the last tick; the newest counts."""
        sample = self._sample
        sample.fresh = False
        for message in self._twist:
            if (twist := numbers_of(message, 6)) is not None:
                rates = *twist[1][:3], *(self._turn.lever_m * rate for rate in twist[1][3:])
                if finite(velocity := value(rates[: self._dof])):
                    sample.xd, self._twist_ns = velocity, due_ns
        for message in self._pose:
            if (place := along(message, self._dof, self._turn)) is not None:
                self._move(value(place[1]), place[0], due_ns)
        return sample

    def _move(self, x: Value, stamp_ns: int, now_ns: int) -> None:
        """Take a new position over; without a driver's velocity form one."""
        if not finite(x):
            return
        sample = self._sample
        if self._twist_ns is None or now_ns - self._twist_ns > STALE_NS:
            span_ns = stamp_ns - self._stamp_ns
            if 0 < span_ns <= STALE_NS:
                sample.xd = (x - sample.x) / (span_ns * 1e-9)
            elif span_ns:
                sample.xd = self._zero
        sample.x, self._stamp_ns = x, stamp_ns
        sample.orientation = self._turn.orientation
        sample.valid = sample.fresh = True

    def write(self, f_m: Value) -> None:
        """Publish the force on the hand."""
        push = (*map(float, flatten(-f_m)), *(0.0,) * 5)[:6]
        self._force.publish(wrench(push[:3], [self._turn.lever_m * each for each in push[3:]]))

    def couple(self) -> None:
        """Do nothing: a person needs no start."""

    def stop(self) -> None:
        """Publish zero force."""
        self.write(self._zero)

    def close(self) -> None:
        """Nothing to give back: the node owns publisher and subscriptions."""
