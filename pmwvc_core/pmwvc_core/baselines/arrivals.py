# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The arriving energy of a peer: the growth of the running sum that its packets carry.

A sum makes loss, duplicates and reordering harmless: the newest packet contains all earlier ones.
Energy sent by an earlier life of the peer, or before its first packet arrived, is not counted:
it is lost, never gained.
"""

from pmwvc_core.numeric import Value, maximum
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket


class Arrivals(Stateful):
    """The receiving end of one peer's running sum [J]."""

    MEMORY = "_epoch _sum"

    def __init__(self) -> None:
        self._epoch: int | None = None
        self._sum: Value = 0.0

    def take(self, packet: WavePacket) -> Value:
        """Return the energy that this packet brings beyond all before it [J]."""
        if packet.epoch != self._epoch:
            self._epoch, self._sum = packet.epoch, packet.energy
        gained = maximum(packet.energy - self._sum, 0.0)
        self._sum = self._sum + gained
        return gained
