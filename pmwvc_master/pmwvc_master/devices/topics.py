# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What devices need of ROS: stamped vectors as serialized messages, and the targets of a hand.

PoseStamped, PointStamped, TwistStamped and WrenchStamped (CDR) begin alike::

    0  encapsulation (byte 1: 1 for little endian)    12  length of frame_id with its final 0
    4  stamp         (int32 s, uint32 ns)             16  frame_id

The numbers follow at the next multiple of 8, counted from byte 4. A message object costs 20 us in
Python, this 2 us.
"""

import struct
import time
from collections.abc import Sequence

from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool

from pmwvc_core.ends.forms import value
from pmwvc_core.ends.simulated_device import Target
from pmwvc_core.errors import ParameterError
from pmwvc_core.runtime.topics import Polled

MOST_AXES = 3  # of a point or a pose
# A reliable publisher matches as well.
HAND_QOS = QoSProfile(depth=4, reliability=ReliabilityPolicy.BEST_EFFORT)
_NS_PER_S = 10**9
_HEADS = {0: struct.Struct(">iII"), 1: struct.Struct("<iII")}
_NUMBERS = {0: struct.Struct(">3d"), 1: struct.Struct("<3d")}
_WRENCH = struct.Struct("<4xiII4x6d")  # frame_id "": its final 0, then up to a multiple of 8


def first_vector(message: bytes) -> tuple[int, tuple[float, float, float]] | None:
    """Return stamp [ns] and the first three numbers of a stamped message; None if it is none."""
    if len(message) < 16 or message[1] not in _HEADS:
        return None
    seconds, nanoseconds, length = _HEADS[message[1]].unpack_from(message, 4)
    begin = 4 + (12 + length + 7) // 8 * 8
    if len(message) < begin + 24:
        return None
    x, y, z = _NUMBERS[message[1]].unpack_from(message, begin)
    return seconds * _NS_PER_S + nanoseconds, (x, y, z)


def wrench(force: tuple[float, float, float]) -> bytes:
    """Return a serialized WrenchStamped of now with this force [N] and no torque."""
    seconds, nanoseconds = divmod(time.time_ns(), _NS_PER_S)
    message = bytearray(_WRENCH.pack(seconds, nanoseconds, 1, *force, 0.0, 0.0, 0.0))
    message[1] = 1
    return bytes(message)


class HandTopics:
    """Targets from ``hand/target`` and ``hand/held``, relative to the node's.

    A target holds the handle; age counts from its arrival, so nobody's clock matters.
    ``held: false`` lets go at once, and targets are ignored until ``held: true``; who never
    publishes ``held`` lets go by silence, or with a target that is not finite. ParameterError
    where a point cannot hold that many axes.
    """

    def __init__(self, node: Node, *, dof: int) -> None:
        if dof > MOST_AXES:
            raise ParameterError(
                f"operator.kind = 'remote': a point has {MOST_AXES} axes; "
                f"set dof = {dof} to {MOST_AXES} or less"
            )
        self._dof = dof
        self._targets = Polled(node, PointStamped, "hand/target", HAND_QOS, raw=True)
        self._held = Polled(node, Bool, "hand/held", HAND_QOS)
        self._open = True  # targets count

    def take(self) -> Sequence[Target]:
        """Return the targets that arrived since the last call; None lets go."""
        found: list[Target] = []
        while (message := self._held.take()) is not None:
            self._open = bool(message.data)
            found += [] if self._open else [None]
        while (data := self._targets.take()) is not None:
            point = first_vector(data)
            if point is not None and self._open:
                found.append(value(point[1][: self._dof]))
        return found
