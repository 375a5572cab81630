# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The packets of one user as ROS topics: one way in, one way out."""

import time

from rclpy.node import Node

from pmwvc_core.runtime.messages.types import MessageTypes
from pmwvc_core.runtime.messages.wire import packet_of, wave_bytes
from pmwvc_core.runtime.polling import RECORDED_QOS, WAVE_QOS, Polled, offered
from pmwvc_core.runtime.records import record_of
from pmwvc_core.transport.admission import Admission
from pmwvc_core.transport.packet import Verdict, WavePacket, refused, size_bytes

MOST_AT_ONCE = 32  # packets taken in one call: a flood takes no more of a loop's time
OF_TOKENS = (Verdict.OTHER_SESSION, Verdict.FORGED)
QUIET_NS = 500_000_000  # an end that has sent nothing for so long answers a wrong token
LONGEST_WAIT_NS = 1_000_000_000  # in the queue; beyond, a wall clock was set meanwhile


class WaveTopics:
    """One end of a user's link, with packets of ``dof`` axes, one sent every ``period_s`` [s];
    ``admission`` seals what is sent and judges what comes in.

    A server sends nothing to a user whose packets it refuses. So that the user learns of a wrong
    token, a quiet end answers with an empty packet, which every receiver refuses.
    """

    def __init__(
        self,
        node: Node,
        types: MessageTypes,
        *,
        incoming: str,
        outgoing: str,
        admission: Admission,
        dof: int,
        extra: int,
        period_s: float,
    ) -> None:
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
