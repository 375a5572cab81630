# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One direction of one user's network in virtual time: sender's log, link and receiver; and the
traces of packets on both sides, of their fates and receptions.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from pmwvc_core.ends.forms import vector
from pmwvc_core.network.in_flight import Cause, Fate, RecordedLink
from pmwvc_core.network.link import Link
from pmwvc_core.numeric import Array, Integers, Value
from pmwvc_core.params import LinkParams
from pmwvc_core.traces import FateTraces, PacketTraces, ReceptionTraces, SessionTraces, TakenTraces
from pmwvc_core.transport.packet import Receipt, WavePacket, refused, size_bytes
from pmwvc_core.transport.receiver import Receiver, counts, passage


class SimulatedLink:
    """Everything between a sender and its receiver ``inbox``, with the record of what passed;
    ``link`` are settings, with the random ``seed``, or the link itself, as recorded; 0 up, 1 down.
    """

    def __init__(
        self, link: LinkParams | RecordedLink, *, seed: Sequence[int], inbox: Receiver, dof: int,
        direction: int,
    ) -> None:  # fmt: skip
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
                packets.append(refused(Receipt.CORRUPTED))
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

    def traces(
        self, looks_ns: Sequence[int], other_controller: int = 0
    ) -> tuple[FateTraces, ReceptionTraces, TakenTraces, list[PacketTraces]]:
        """Return fates, counts, packets taken in at looks [ns], and packets on both sides."""
        fates, arrived, nameless = self.fates, self.arrived[: self.taken], ""
        number, size_bytes, time_in_ns, due_ns, kind, cause = _columns(
            [(f.number, f.size, f.time_in_ns, f.time_due_ns, f.kind, f.cause) for f in fates], 6
        )
        epochs = np.full(len(fates), self.sent[0].epoch if self.sent else 0, dtype=np.uint64)
        numbers, times_ns = (number, epochs, number.copy()), (time_in_ns, due_ns, due_ns.copy())
        seq, epoch, at_ns = _columns([(each.seq, each.epoch, ns) for each, ns in arrived], 3)
        counted = counts(self.receiver, other_controller=other_controller)
        passed = passage(self.receiver.path.estimate())
        sent = [(packet, packet.sent_ns) for packet in self.sent]
        return (
            FateTraces(nameless, *numbers, size_bytes, *times_ns, kind, cause),
            ReceptionTraces(nameless, receivers=1, counts=counted, passage=passed),
            TakenTraces(np.searchsorted(np.array(looks_ns), at_ns), seq, epoch & 0xFFFFFFFF),
            [_packets(seen, self._dof) for seen in (sent, self.arrived)],
        )


def add_link(
    traces: SessionTraces, user: str, way: str, fates: FateTraces, reception: ReceptionTraces,
    taken: TakenTraces, packets: Sequence[PacketTraces],
) -> None:  # fmt: skip
    """Add the traces of a user's link, up or down, to those of a session, by their names."""
    name, sides = f"{user}/{way}", (f"/{user}", f"/server/{user}")
    traces.fates[name] = replace(fates, link=name)
    traces.receptions[name] = replace(reception, link=name)
    traces.taken[name] = taken
    for side, seen in zip(sides if way == "up" else sides[::-1], packets, strict=True):
        topic = f"{side}/wave_{way}"
        traces.packets[topic] = replace(seen, topic=topic)
        traces.counts[topic] = {"messages": len(seen.seq), "missing": 0}


def _columns(rows: Sequence[Sequence[int]], width: int) -> Integers:
    return np.array(rows, dtype=np.int64).reshape(-1, width).T.copy()


def _packets(seen: Sequence[tuple[WavePacket, int]], dof: int) -> PacketTraces:
    """Return packets, with the times at which they were seen [ns]."""
    packets = [packet for packet, _ in seen]
    times_s = np.array([time_ns for _, time_ns in seen], dtype=float) * 1e-9
    epoch, seq, sent_ns = _columns([(each.epoch, each.seq, each.sent_ns) for each in packets], 3)
    period_s, energy = (
        columns((getattr(each, name) for each in packets), 1)[:, 0]
        for name in ("period", "energy")
    )
    wave, integral, position = (
        columns((getattr(each, name) for each in packets), dof)
        for name in ("wave", "integral", "position")
    )
    sums = wave, integral, energy, position
    return PacketTraces("", times_s, epoch.astype(np.uint64), seq, sent_ns, period_s, *sums)


def columns(values: Iterable[Value], axes: int) -> Array:
    """Return signals ``(rows, axes)``; a number stands for all axes."""
    every = [vector(value, axes) for value in values]
    return np.array(every, dtype=float).reshape(len(every), axes)
