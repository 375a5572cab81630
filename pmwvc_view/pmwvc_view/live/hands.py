# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The hands of a page as ROS topics: ``hand/target`` and ``hand/held`` of each user.

Targets are published as bytes (CDR, little endian): a fifth of what message objects cost.
"""

import asyncio
import struct
import time
from collections.abc import Sequence

from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool

TARGET_QOS = QoSProfile(depth=4, reliability=ReliabilityPolicy.BEST_EFFORT)
HELD_QOS = QoSProfile(depth=4, reliability=ReliabilityPolicy.RELIABLE)
LEAST_S = 0.008  # between two targets; a page that sends more is followed at this pace
AGAIN_S = 0.04  # a target that stays where it is is published this often; 0.15 s: let go
HELD_S = 0.13  # between two repetitions of what holds
_TARGET = struct.Struct("<4siIIc3x3d")  # encapsulation, stamp, empty name of a frame, point


def target_bytes(position: Sequence[float], stamp_ns: int) -> bytes:
    """Return a target [m] as a serialized PointStamped; axes that there are not are zero."""
    sec, nanosec = divmod(stamp_ns, 1_000_000_000)
    point = (*position[:3], 0.0, 0.0)[:3]
    return _TARGET.pack(b"\x00\x01\x00\x00", sec, nanosec, 1, b"\0", *point)


class PublishedHand:
    """The hand of one user, below the namespace ``topics``; ``position`` is its target while it is
    closed [m].
    """

    def __init__(self, node: Node, topics: str) -> None:
        self._targets = node.create_publisher(PointStamped, f"{topics}/hand/target", TARGET_QOS)
        self._flags = node.create_publisher(Bool, f"{topics}/hand/held", HELD_QOS)
        self.position: Sequence[float] | None = None
        self._sent: Sequence[float] | None = None
        self._sent_s = self._held_s = 0.0
        self._later: asyncio.TimerHandle | None = None

    def give(self, position: Sequence[float] | None) -> None:
        """Publish a target, at once or as soon as the pace allows; None opens the hand."""
        if position is None:
            if self._later is not None:
                self._later.cancel()
                self._later = None
            if self.position is not None:
                self.position = None
                self._flags.publish(Bool(data=False))
            return
        loop = asyncio.get_running_loop()
        now_s = loop.time()
        if self.position is None:
            self._flags.publish(Bool(data=True))
            self._sent, self._held_s = None, now_s
        self.position = position
        wait_s = self._sent_s - now_s + (AGAIN_S if position == self._sent else LEAST_S)
        if wait_s <= 0.0:
            self._publish()
        elif self._later is None and position != self._sent:
            self._later = loop.call_later(wait_s, self._publish)

    def _publish(self) -> None:
        """Publish the newest target."""
        self._later = None
        if self.position is None:
            return
        self._sent, self._sent_s = self.position, asyncio.get_running_loop().time()
        if self._sent_s - self._held_s > HELD_S:  # a master that was started meanwhile, missed it
            self._held_s = self._sent_s
            self._flags.publish(Bool(data=True))
        self._targets.publish(target_bytes(self.position, time.time_ns()))
