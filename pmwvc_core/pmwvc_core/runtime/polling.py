# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Subscriptions that a loop empties itself: taking a message so costs a few microseconds, an
executor's turn 150.

An executor that serves the same node passes over them, so it never takes a message away from the
loop.
"""

from importlib import import_module
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from pmwvc_core.runtime.records import KEPT

WAVE_QOS = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
RECORDED_QOS = QoSProfile(depth=KEPT, reliability=ReliabilityPolicy.RELIABLE)
# deep enough that a flood does not push out the packets of a sender
TAKEN_QOS = QoSProfile(depth=64, reliability=ReliabilityPolicy.BEST_EFFORT)
DEADLINE_PERIODS = 3


def message_class(type_name: str) -> Any:
    """Return the class of messages of a type, ``package/msg/Name``."""
    package, _, name = type_name.partition("/msg/")
    return getattr(import_module(f"{package}.msg"), name)


def offered(qos: QoSProfile, period_s: float) -> QoSProfile:
    """Return a publisher's profile with a deadline of three periods.

    A subscriber that asks for none is matched all the same; one that asks for as much or more is
    notified by the middleware when the topic falls silent. It costs 10 us a message.
    """
    deadline = Duration(nanoseconds=round(DEADLINE_PERIODS * period_s * 1e9))
    return QoSProfile(depth=qos.depth, reliability=qos.reliability, deadline=deadline)


class _Unserved(CallbackGroup):
    """Entities that no executor ever runs."""

    def can_execute(self, entity: Any) -> bool:
        return False

    def beginning_execution(self, entity: Any) -> bool:
        return False

    def ending_execution(self, entity: Any) -> None:
        pass


class Polled:
    """One subscription, emptied by :meth:`take`; its node has to outlive the loop that takes."""

    def __init__(
        self, node: Node, kind: Any, topic: str, qos: QoSProfile = TAKEN_QOS, *, raw: bool = False
    ) -> None:
        self.kind = kind
        self.raw = raw
        self.subscription = node.create_subscription(
            kind, topic, lambda _: None, qos, callback_group=_Unserved()
        )
        self._take = self.subscription.handle.take_message

    def take(self) -> Any:
        """Return the oldest message not yet taken, or None; never waits."""
        taken = self._take(self.kind, self.raw)
        return None if taken is None else taken[0]
