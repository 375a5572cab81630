# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Links with a constant delay, for packets as objects (:mod:`pmwvc_analysis.models.links`).

Who reads takes the newest packet that has arrived: the last one sent ``delay`` ticks ago or
earlier. Only packets that will still be read are states.
"""

from collections import deque
from collections.abc import Callable

from pmwvc_analysis.models.links import AMPLE_J, Times
from pmwvc_core.numeric import Value
from pmwvc_core.transport.packet import WavePacket

Packet = tuple[Value, ...]  # in the order of SIGNALS


class Link:
    """One direction of a link.

    Parameters
    ----------
    sent, read
        When packets are sent and when the receiver looks.
    delay
        Age of a packet at arrival [ticks].
    ticks
        Length of the hyperperiod.

    Attributes
    ----------
    past
        When those packets were sent that are under way at tick 0 and still count.
    read
        Those of them that are read in the hyperperiod.
    packets
        Those sent, by their tick.
    relay
        Where the link is cut: takes what is sent, returns what comes in instead.
    """

    def __init__(self, sent: Times, read: Times, *, delay: int, ticks: int) -> None:
        self._sent, self._delay = sent, delay
        self._looks = range(read.phase, ticks, read.period)
        self.read = {at for look in self._looks if (at := sent.last(look - delay)) < 0}
        older = {at for past in self.read for at in range(past, 0, ticks)}
        self.past = sorted(older)
        self.packets: dict[int, WavePacket] = {}
        self._under_way: deque[tuple[int, WavePacket]] = deque()
        self._newest: WavePacket | None = None
        self.relay: Callable[[Packet], Packet] | None = None

    def send(self, tick: int, packet: WavePacket | None) -> None:
        """Put a packet in, or what the relay makes of it."""
        if packet is None:
            return
        if self.relay is not None:
            packet.wave, packet.position = self.relay((packet.wave, packet.position))
        self.packets[tick] = packet
        self._under_way.append((tick + self._delay, packet))

    def collect(self, tick: int) -> list[WavePacket]:
        """Return the packets that have arrived. What their sums add to those of the packet before
        is the wave, and energy for whatever a playout does with it.
        """
        arrived: list[WavePacket] = []
        integral: Value = 0.0
        energy = 0.0
        if self._newest is not None:
            self._newest.integral, self._newest.energy = integral, energy
        while self._under_way and self._under_way[0][0] <= tick:
            _, packet = self._under_way.popleft()
            packet.integral = integral = integral + packet.wave * packet.period
            packet.energy = energy = energy + AMPLE_J
            arrived.append(packet)
            self._newest = packet
        return arrived

    def ages(self) -> list[int]:
        """Return how old packets are when they are read [ticks]."""
        return [look - self._sent.last(look - self._delay) for look in self._looks]
