# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of a simulated network: packets on both sides of it, their fates and receptions."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.ends.forms import vector
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.simulation.user import SimulatedUser
from pmwvc_core.traces import FateTraces, PacketTraces, ReceptionTraces, SessionTraces, TakenTraces
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.transport.reception import counts, passage


def add_network(
    traces: SessionTraces, users: Sequence[SimulatedUser], server: Any, *, dof: int
) -> None:
    """Add what links and receivers did, given both ends after the session."""
    faults = {}
    for user in users:
        name = user.settings.name
        for way, link, sender, receiver, end in (
            ("up", user.up, f"/{name}", f"/server/{name}", server),
            ("down", user.down, f"/server/{name}", f"/{name}", user.loop),
        ):
            sent = [(packet, packet.sent_ns) for packet in link.sent]
            for seen, side in ((sent, sender), (link.arrived, receiver)):
                topic = f"{side}/wave_{way}"
                traces.packets[topic] = _packets(seen, topic, dof)
                traces.counts[topic] = {"messages": len(seen), "missing": 0}
            which, inbox = f"{name}/{way}", link.receiver
            traces.fates[which] = fate_traces(link, which)
            traces.receptions[which] = ReceptionTraces(
                which,
                receivers=1,
                counts=counts(inbox, other_controller=end.other_controller),
                passage=passage(inbox.path.estimate()),
            )
            if link.link.faults.count:  # of plug-ins
                faults[which] = str(link.link.faults)
    if faults:
        traces.metadata["links"] = faults


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


def fate_traces(link: SimulatedLink, name: str) -> FateTraces:
    """Return what the link did to each packet.

    In virtual time a packet leaves when it is due; its receiver looks at its own instants.
    """
    records, of = link.fates, _integers
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
    taken, of = link.arrived[: link.taken], _integers
    return TakenTraces(
        row=np.searchsorted(np.array(looks_ns), of([now_ns for _, now_ns in taken])),
        seq=of([packet.seq for packet, _ in taken]),
        epoch=of([packet.epoch for packet, _ in taken]) & 0xFFFFFFFF,
    )


def _integers(values: list[int]) -> NDArray[np.int64]:
    return np.array(values, dtype=np.int64)
