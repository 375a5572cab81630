# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One direction of one user's network in virtual time: sender's log, link and receiver; and the
traces of packets on both sides, of their fates and receptions.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_core.ends.forms import vector
from pmwvc_core.network.in_flight import Cause, Fate, RecordedLink
from pmwvc_core.network.link import Link
from pmwvc_core.numeric import Array
from pmwvc_core.params import LinkParams
from pmwvc_core.traces import FateTraces, PacketTraces, ReceptionTraces, TakenTraces
from pmwvc_core.transport.packet import Verdict, WavePacket, refused, size_bytes
from pmwvc_core.transport.receiver import Receiver, counts, passage


class SimulatedLink:
    """Everything between a sender and its receiver, with the record of what passed.

    Parameters
    ----------
    link, seed
        Settings of the link and its random stream; or the link itself, as recorded.
    inbox
        The receiver at its end.
    direction
        0: from user to server, 1: back.
    """

    def __init__(
        self,
        link: LinkParams | RecordedLink,
        *,
        seed: Sequence[int],
        inbox: Receiver,
        dof: int,
        direction: int,
    ) -> None:
        self.link = (
            link if isinstance(link, RecordedLink) else Link(link, seed=seed, direction=direction)
        )
        self.receiver = inbox
        self.sent: list[WavePacket] = []
        self.arrived: list[tuple[WavePacket, int]] = []  # packet, time [ns]
        self.taken = 0  # of them by the receiver
        self.fates: list[Fate] = []
        self._dof, self._size_bytes = dof, size_bytes(dof)

    def configure(self, params: LinkParams) -> None:
        """Take other settings over; a link as recorded stays as it is."""
        if isinstance(self.link, Link):
            self.link.configure(params)

    def send(self, packet: WavePacket, now_ns: int) -> None:
        """Give a packet to the link."""
        self.sent.append(packet)
        size = self._size_bytes + 8 * len(packet.extra)
        self.fates += self.link.send(packet, now_ns, size_bytes=size)

    def collect(self, now_ns: int) -> list[WavePacket]:
        """Return what has arrived by now, in the order of arrival."""
        packets = []
        for packet, fate in self.link.arrivals(now_ns):
            if fate.cause is Cause.CORRUPTION:
                packets.append(refused(Verdict.CORRUPTED))
                continue
            packets.append(packet)
            self.arrived.append((packet, now_ns))
        self.taken = len(self.arrived)
        return packets

    def drain(self, end_ns: int) -> None:
        """Note what came out before the end of the session but was not looked at any more."""
        for packet, fate in self.link.arrivals(end_ns - 1):
            if fate.cause is not Cause.CORRUPTION:
                self.arrived.append((packet, fate.time_due_ns))

    def packet_traces(self, sent_on: str, arrived_on: str) -> list[PacketTraces]:
        """Return the packets on both sides, by their topics."""
        sent = [(packet, packet.sent_ns) for packet in self.sent]
        return [_packets(sent, sent_on, self._dof), _packets(self.arrived, arrived_on, self._dof)]

    def reception(self, name: str, *, other_controller: int = 0) -> ReceptionTraces:
        """Return what the receiver counted."""
        counted = counts(self.receiver, other_controller=other_controller)
        passed = passage(self.receiver.path.estimate())
        return ReceptionTraces(name, receivers=1, counts=counted, passage=passed)

    def fate_traces(self, name: str) -> FateTraces:
        """Return what the link did to each packet. In virtual time a packet leaves when it is due;
        its receiver looks at its own instants.
        """

        def of(values: list[int]) -> Any:
            return np.array(values, dtype=np.int64)

        records = self.fates
        epoch, due = self.sent[0].epoch if self.sent else 0, [each.time_due_ns for each in records]
        return FateTraces(
            link=name,
            number=of([each.number for each in records]),
            epoch=np.full(len(records), epoch, dtype=np.uint64),
            seq=of([each.number for each in records]),
            size_bytes=of([each.size for each in records]),
            time_in_ns=of([each.time_in_ns for each in records]),
            time_due_ns=of(due),
            time_out_ns=of(due),
            fate=of([int(each.kind) for each in records]),
            cause=of([int(each.cause) for each in records]),
        )

    def taken_traces(self, looks_ns: Sequence[int]) -> TakenTraces:
        """Return what the receiver was given, by the times at which it looked [ns]."""
        rows = [
            (packet.seq, packet.epoch, now_ns) for packet, now_ns in self.arrived[: self.taken]
        ]
        seq, epoch, at_ns = np.array(rows, dtype=np.int64).reshape(-1, 3).T.copy()
        return TakenTraces(np.searchsorted(np.array(looks_ns), at_ns), seq, epoch & 0xFFFFFFFF)


def _packets(seen: Sequence[tuple[WavePacket, int]], topic: str, dof: int) -> PacketTraces:
    """Return packets seen on a topic, with the times at which they were seen [ns]."""
    packets = [packet for packet, _ in seen]

    def of(name: str, kind: Any = float) -> Any:
        return np.array([getattr(packet, name) for packet in packets], dtype=kind)

    def vectors(name: str, axes: int = dof) -> Array:
        values = [vector(getattr(packet, name), axes) for packet in packets]
        return np.array(values, dtype=float).reshape(len(packets), axes)

    return PacketTraces(
        topic=topic,
        time_s=np.array([time_ns for _, time_ns in seen], dtype=float) * 1e-9,
        epoch=of("epoch", np.uint64),
        seq=of("seq", np.int64),
        sent_ns=of("sent_ns", np.int64),
        period_s=of("period"),
        wave=vectors("wave"),
        integral=vectors("integral"),
        energy=vectors("energy", 1)[:, 0],
        position=vectors("position"),
    )
