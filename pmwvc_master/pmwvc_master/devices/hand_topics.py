# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The targets of a remote hand as ROS topics: ``hand/target`` and ``hand/held``.

A target holds the handle; age counts from its arrival, so nobody's clock matters. ``held: false``
lets go at once, and targets are ignored until ``held: true``; who never publishes ``held`` lets go
by silence, or with a target that is not finite.
"""

from collections.abc import Sequence

from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool

from pmwvc_core.ends.simulated_device import Target
from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import signal
from pmwvc_core.runtime.topics import Polled
from pmwvc_master.devices import cdr

MOST_AXES = 3
# A reliable publisher matches as well.
HAND_QOS = QoSProfile(
    depth=4, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE
)


class HandTopics:
    """A :class:`pmwvc_core.ends.simulated_device.TargetSource`; topics are relative to the
    node's. ParameterError where a point cannot hold that many axes.
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
            point = cdr.first_vector(data)
            if point is not None and self._open:
                found.append(signal(point[1][: self._dof], self._dof))
        return found
