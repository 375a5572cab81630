# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One direction of one user's network in virtual time: sender's log, link and receiver.

The runs of a batch share one network: what is compared within a batch meets the same packet fates.
A run that has run away beyond all numbers is nobody else's concern: from then on its own packets
say zero.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from pmwvc_core.network.link import Link
from pmwvc_core.network.recorded_link import RecordedLink
from pmwvc_core.network.transit import Fate
from pmwvc_core.numeric import Value
from pmwvc_core.params import LinkParams
from pmwvc_core.wave.packet import WavePacket, size_bytes
from pmwvc_core.wave.receiver import Receiver


class Path:
    """Everything between a sender and its receiver, with the record of what passed.

    Parameters
    ----------
    link, seed
        Settings of the link and its random stream; or the link itself, as recorded.
    period_s, timeout_s, dof
        What the receiver expects: packet interval [s], silence allowed [s], values per packet.
    """

    def __init__(
        self,
        link: LinkParams | RecordedLink,
        *,
        seed: Sequence[int],
        period_s: float,
        timeout_s: float,
        dof: int,
    ) -> None:
        self.link = link if isinstance(link, RecordedLink) else Link(link, seed=seed)
        self.receiver = Receiver(dof, period_s=period_s, timeout_s=timeout_s)
        self.sent: list[WavePacket] = []
        self.arrived: list[tuple[WavePacket, int]] = []  # packet, time [ns]
        self.fates: list[Fate] = []
        self._size_bytes = size_bytes(dof)

    def send(self, packet: WavePacket, now_ns: int) -> None:
        """Give a packet to the link."""
        packet = _each_for_itself(packet)
        self.sent.append(packet)
        self.fates += self.link.send(packet, now_ns, size_bytes=self._size_bytes)

    def collect(self, now_ns: int) -> list[WavePacket]:
        """Return what has arrived by now, in the order of arrival."""
        packets = []
        for packet, _ in self.link.arrivals(now_ns):
            packets.append(packet)
            self.arrived.append((packet, now_ns))
        return packets

    def drain(self, end_ns: int) -> None:
        """Note what came out before the end of the session but was not looked at any more."""
        for packet, fate in self.link.arrivals(end_ns - 1):
            self.arrived.append((packet, fate.time_due_ns))


def _each_for_itself(packet: WavePacket) -> WavePacket:
    """Return a packet of a batch that its receiver takes whatever a single run has come to.

    Where there is only one run a packet that is not finite is refused, as live.
    """
    if type(packet.wave) is type(packet.position) is float:
        return packet
    values = {name: getattr(packet, name) for name in ("wave", "integral", "energy", "position")}
    wild = {name: value for name, value in values.items() if _is_wild(value)}
    if not wild:
        return packet
    tamed = {n: np.nan_to_num(v, nan=0.0, posinf=0.0, neginf=0.0) for n, v in wild.items()}
    return dataclasses.replace(packet, **tamed)


def _is_wild(value: Value) -> bool:
    return isinstance(value, np.ndarray) and value.ndim == 2 and not np.isfinite(value).all()
