# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Topics of a loop: subscriptions that it empties itself (some microseconds; an executor's turn
150, and it passes over them), and the packets of one user, one way in and one way out.
"""

import time
from importlib import import_module
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from pmwvc_core.runtime.messages import KEPT, MessageTypes, record_of
from pmwvc_core.runtime.wire import packet_of, wave_bytes
from pmwvc_core.transport.admission import Admission
from pmwvc_core.transport.packet import Verdict, WavePacket, refused, size_bytes

WAVE_QOS = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
RECORDED_QOS = QoSProfile(depth=KEPT, reliability=ReliabilityPolicy.RELIABLE)
# deep enough that a flood does not push out the packets of a sender
TAKEN_QOS = QoSProfile(depth=64, reliability=ReliabilityPolicy.BEST_EFFORT)
DEADLINE_PERIODS = 3
MOST_AT_ONCE = 32  # packets taken in one call: a flood takes no more of a loop's time
OF_TOKENS = (Verdict.OTHER_SESSION, Verdict.FORGED)
QUIET_NS = 500_000_000  # an end that has sent nothing for so long answers a wrong token
LONGEST_WAIT_NS = 1_000_000_000  # in the queue; beyond, a wall clock was set meanwhile


def message_class(type_name: str) -> Any:
    """Return the class of messages of a type, ``package/msg/Name``."""
    package, _, name = type_name.partition("/msg/")
    return getattr(import_module(f"{package}.msg"), name)


def offered(qos: QoSProfile, period_s: float) -> QoSProfile:
    """Return a publisher's profile with a deadline of three periods, of which the middleware
    notifies subscribers that ask for as much or more. It costs 10 us a message.
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


class WaveTopics:
    """One end of a user's link, with packets of ``dof`` axes every ``period_s`` [s]; ``admission``
    seals and judges. A quiet end answers packets of a wrong token with an empty one, which every
    receiver refuses: so the user learns of it.
    """

    def __init__(
        self, node: Node, types: MessageTypes, *, incoming: str, outgoing: str,
        admission: Admission, dof: int, extra: int, period_s: float,
    ) -> None:  # fmt: skip
        self._admission = admission
        self._dof = dof
        self._whole = size_bytes(dof, extra)
        self._sent_ns = 0
        inlet = Polled(node, types.Wave, incoming, raw=True)
        self._kind, self._inlet = inlet.kind, inlet.subscription.handle
        self._out = node.create_publisher(types.Wave, outgoing, offered(WAVE_QOS, period_s))
        record = record_of(self._out.topic_name)
        self._record = node.create_publisher(types.Wave, record, RECORDED_QOS)

    def take(self) -> list[WavePacket]:
        """Return the packets that have arrived since the last call; never wait."""
        packets: list[WavePacket] = []
        take = self._inlet.take_message
        while len(packets) < MOST_AT_ONCE and (taken := take(self._kind, True)) is not None:
            data, info = taken
            now_ns = time.monotonic_ns()
            waited_ns = time.time_ns() - int(info["received_timestamp"])
            came_ns = now_ns - waited_ns if 0 <= waited_ns <= LONGEST_WAIT_NS else now_ns
            verdict = None
            if len(data) == self._whole:
                verdict = self._admission.judge(data, now_ns)
            if verdict in OF_TOKENS and now_ns - self._sent_ns > QUIET_NS:
                self.send(refused(Verdict.MALFORMED))
            packets.append(refused(verdict) if verdict else packet_of(data, came_ns=came_ns))
        return packets

    def send(self, packet: WavePacket) -> None:
        """Publish a packet."""
        self._sent_ns = time.monotonic_ns()
        data = self._admission.sealed(wave_bytes(packet, time.time_ns(), dof=self._dof))
        self._out.publish(data)
        self._record.publish(data)
