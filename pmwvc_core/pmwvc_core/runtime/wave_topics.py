# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The packets of one user as ROS topics: one way in, one way out."""

import time

from rclpy.node import Node

from pmwvc_core.runtime.messages.types import MessageTypes
from pmwvc_core.runtime.messages.waves import read_wave, wave
from pmwvc_core.runtime.polling import WAVE_QOS, Polled, offered
from pmwvc_core.transport.packet import WavePacket


class WaveTopics:
    """One end of a user's link.

    Parameters
    ----------
    node, types
        The node that owns subscription and publisher, and its message types.
    incoming, outgoing
        Names of the topics.
    dof, period_s
        Axes of the packets, and the interval of those sent [s].
    """

    def __init__(
        self,
        node: Node,
        types: MessageTypes,
        *,
        incoming: str,
        outgoing: str,
        dof: int,
        period_s: float,
    ) -> None:
        self._types = types
        self._dof = dof
        self._in = Polled(node, types.Wave, incoming)
        self._out = node.create_publisher(types.Wave, outgoing, offered(WAVE_QOS, period_s))

    def take(self) -> list[WavePacket]:
        """Return the packets that have arrived since the last call; never wait."""
        packets = []
        while (message := self._in.take()) is not None:
            packets.append(read_wave(message, self._dof))
        return packets

    def send(self, packet: WavePacket) -> None:
        """Publish a packet."""
        self._out.publish(wave(self._types, packet, time.time_ns(), dof=self._dof))
