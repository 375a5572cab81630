# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The hands of a page as ROS topics: ``hand/target`` and ``hand/held`` of each user."""

import asyncio
from collections.abc import Sequence

from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool

TARGET_QOS = QoSProfile(depth=4, reliability=ReliabilityPolicy.BEST_EFFORT)
HELD_QOS = QoSProfile(depth=4, reliability=ReliabilityPolicy.RELIABLE)
LEAST_S = 0.008  # between two targets; a page that sends more is followed at this pace
REPEAT = 16  # targets between two repetitions of what holds


class PublishedHand:
    """The hand of one user.

    Parameters
    ----------
    node
        Publishes.
    topics
        Namespace of the user.
    """

    def __init__(self, node: Node, topics: str) -> None:
        self._node = node
        self._targets = node.create_publisher(PointStamped, f"{topics}/hand/target", TARGET_QOS)
        self._flags = node.create_publisher(Bool, f"{topics}/hand/held", HELD_QOS)
        self._position: Sequence[float] | None = None
        self._sent_s = 0.0
        self._count = 0
        self._later: asyncio.TimerHandle | None = None

    @property
    def position(self) -> Sequence[float] | None:
        """The target while the hand is closed [m]."""
        return self._position

    def give(self, position: Sequence[float] | None) -> None:
        """Publish a target, at once or as soon as the pace allows; None opens the hand."""
        if position is None:
            self._open()
            return
        if self._position is None:
            self._flags.publish(Bool(data=True))
            self._count = 0
        self._position = position
        loop = asyncio.get_running_loop()
        wait_s = self._sent_s + LEAST_S - loop.time()
        if wait_s <= 0.0:
            self._publish()
        elif self._later is None:
            self._later = loop.call_later(wait_s, self._publish)

    def _open(self) -> None:
        if self._later is not None:
            self._later.cancel()
            self._later = None
        if self._position is not None:
            self._position = None
            self._flags.publish(Bool(data=False))

    def _publish(self) -> None:
        """Publish the newest target."""
        self._later = None
        if self._position is None:
            return
        self._sent_s = asyncio.get_running_loop().time()
        self._count += 1
        if self._count % REPEAT == 0:  # a master that was started meanwhile, or missed it
            self._flags.publish(Bool(data=True))
        message = PointStamped()
        message.header.stamp = self._node.get_clock().now().to_msg()
        for axis, value in zip("xyz", self._position, strict=False):
            setattr(message.point, axis, float(value))
        self._targets.publish(message)
