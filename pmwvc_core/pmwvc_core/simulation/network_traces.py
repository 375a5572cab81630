# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of a simulated network: packets on both sides of it, their fates and receptions."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.simulation.user import SimulatedUser
from pmwvc_core.traces import FateTraces, PacketTraces, ReceptionTraces, SessionTraces, TakenTraces
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.transport.reception import counts, passage


class NetworkTraces:
    """The traces of a batch's network; all runs share fates and receptions.

    Parameters
    ----------
    users, server
        Both ends of the links, after the session.
    """

    def __init__(
        self, users: Sequence[SimulatedUser], server: Any, *, runs: int, dof: int
    ) -> None:
        self._tables: list[PacketTable] = []
        self._fates: dict[str, FateTraces] = {}
        self._receptions: dict[str, ReceptionTraces] = {}
        self._faults: dict[str, str] = {}
        for user in users:
            name = user.settings.name
            for way, link, sender, receiver, end in (
                ("up", user.up, f"/{name}", f"/server/{name}", server),
                ("down", user.down, f"/server/{name}", f"/{name}", user.loop),
            ):
                sent = [(packet, packet.sent_ns) for packet in link.sent]
                for seen, side in ((sent, sender), (link.arrived, receiver)):
                    table = PacketTable(seen, f"{side}/wave_{way}", runs=runs, dof=dof)
                    self._tables.append(table)
                which, inbox = f"{name}/{way}", link.receiver
                self._fates[which] = fate_traces(link, which)
                self._receptions[which] = ReceptionTraces(
                    which,
                    receivers=1,
                    counts=counts(inbox, other_controller=end.other_controller),
                    passage=passage(inbox.path.estimate()),
                )
                if link.link.faults.count:  # of plug-ins
                    self._faults[which] = str(link.link.faults)

    def add_to(self, traces: SessionTraces, run: int) -> None:
        """Add what one run sent, and what all share."""
        if self._faults:
            traces.metadata["links"] = dict(self._faults)
        traces.receptions = dict(self._receptions)
        traces.fates = dict(self._fates)
        for table in self._tables:
            packets = table.run(run)
            traces.packets[table.topic] = packets
            traces.counts[table.topic] = {"messages": len(packets.seq), "missing": 0}


class PacketTable:
    """Packets seen on one topic, for all runs of a batch at once.

    Parameters
    ----------
    seen
        Packets with the times at which they were seen [ns].
    """

    def __init__(
        self, seen: Sequence[tuple[WavePacket, int]], topic: str, *, runs: int, dof: int
    ) -> None:
        packets = [packet for packet, _ in seen]

        def of(name: str, width: int) -> Array:
            if runs == dof == 1:
                values = [getattr(packet, name) for packet in packets]
                return np.array(values, dtype=float).reshape(len(packets), 1, 1)
            rows = np.zeros((len(packets), runs, width))
            for row, packet in zip(rows, packets, strict=True):
                row[:] = getattr(packet, name)
            return rows

        self.topic = topic
        self._time_s = np.array([time_ns for _, time_ns in seen], dtype=float) * 1e-9
        self._epoch = np.array([packet.epoch for packet in packets], dtype=np.uint64)
        self._seq = np.array([packet.seq for packet in packets], dtype=np.int64)
        self._sent_ns = np.array([packet.sent_ns for packet in packets], dtype=np.int64)
        self._period_s = np.array([packet.period for packet in packets], dtype=float)
        self._wave, self._integral = of("wave", dof), of("integral", dof)
        self._position = of("position", dof)
        self._energy = of("energy", 1)

    def run(self, run: int) -> PacketTraces:
        """Return the packets as one run sent them."""
        return PacketTraces(
            topic=self.topic,
            time_s=self._time_s,
            epoch=self._epoch,
            seq=self._seq,
            sent_ns=self._sent_ns,
            period_s=self._period_s,
            wave=self._wave[:, run].copy(),
            integral=self._integral[:, run].copy(),
            energy=self._energy[:, run, 0].copy(),
            position=self._position[:, run].copy(),
        )


def fate_traces(link: SimulatedLink, name: str) -> FateTraces:
    """Return what the link did to each packet.

    In virtual time a packet leaves when it is due; its receiver looks at its own instants.
    """
    records = link.fates

    def of(values: list[int]) -> NDArray[np.int64]:
        return np.array(values, dtype=np.int64)

    due = of([fate.time_due_ns for fate in records])
    return FateTraces(
        link=name,
        number=of([fate.number for fate in records]),
        epoch=np.full(len(records), link.sent[0].epoch if link.sent else 0, dtype=np.uint64),
        seq=of([fate.number for fate in records]),
        size_bytes=of([fate.size for fate in records]),
        time_in_ns=of([fate.time_in_ns for fate in records]),
        time_due_ns=due,
        time_out_ns=due.copy(),
        fate=of([int(fate.kind) for fate in records]),
        cause=of([int(fate.cause) for fate in records]),
    )


def taken_traces(link: SimulatedLink, looks_ns: Sequence[int]) -> TakenTraces:
    """Return what a receiver was given, by the times at which it looked [ns]."""
    taken = link.arrived[: link.taken]

    def of(values: list[int]) -> NDArray[np.int64]:
        return np.array(values, dtype=np.int64)

    return TakenTraces(
        row=np.searchsorted(np.array(looks_ns), of([now_ns for _, now_ns in taken])),
        seq=of([packet.seq for packet, _ in taken]),
        epoch=of([packet.epoch for packet, _ in taken]) & 0xFFFFFFFF,
    )
