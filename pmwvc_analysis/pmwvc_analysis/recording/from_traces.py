# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session folder of a run that was simulated or replayed, as a live run leaves it.

Same topics, types and blocks; what virtual time does not have (echoes; lateness, but in a replay)
is zero.
"""

import itertools
import json
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.assemble import TRACES
from pmwvc_analysis.recording.links import Outgoing, fate_blocks
from pmwvc_analysis.recording.topics import SCENE, about, session_topics
from pmwvc_analysis.recording.writer import SessionWriter
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.ends.server_end import SERVER_EPOCH
from pmwvc_core.errors import file_errors
from pmwvc_core.runtime import messages as build
from pmwvc_core.runtime.messages import OF_OBJECT, MessageTypes
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import (
    OF_USERS,
    PacketTraces,
    ServerTraces,
    SessionTraces,
    TakenTraces,
    UserTraces,
)
from pmwvc_core.transport.packet import FLAG_DIRECT, WavePacket

KEPT = ("environment", "coupling", "links", "replay")  # faults, and what a replay changed
OF_STEP = (*OF_OBJECT, "kinetic", "potential", "dissipated")


def record_traces(
    folder: str | Path,
    traces: SessionTraces,
    scenario: Scenario,
    *,
    start_ns: int | None = None,
) -> None:
    """Write traces as ``session.mcap``, ``metadata.yaml`` and ``scenario.yaml``.

    ``start_ns`` is the ROS time of the start of the session, now when not given [ns].
    """
    start = time.time_ns() if start_ns is None else start_ns
    text = yaml.safe_dump(scenario.to_dict(), sort_keys=False, allow_unicode=True)
    with file_errors(f"record into {folder}"):
        Path(folder).mkdir(parents=True, exist_ok=True)
        (Path(folder) / "scenario.yaml").write_text(text, encoding="utf-8")
    store = schemas.typestore()
    types = build.types_from(store.types)
    outgoing = sorted(_all(types, traces, scenario, start), key=lambda item: item[0])
    names = [user.name for user in traces.users]
    with SessionWriter(folder) as writer:
        known = {name: traces.metadata[name] for name in KEPT if name in traces.metadata}
        records = about(scenario, source=traces.source) | known
        for name, values in records.items():
            writer.add_metadata(name, values)
        for topic in session_topics(names, links=list(traces.fates)):
            writer.add_topic(topic)
        for at_ns, name, message in outgoing:
            data = bytes(store.serialize_cdr(message, message.__msgtype__))
            writer.write(name, data, log_ns=start + at_ns)


def _all(
    types: MessageTypes, traces: SessionTraces, scenario: Scenario, start: int
) -> Iterator[Outgoing]:
    for user in traces.users:
        yield from _master_blocks(types, user, traces, start)
    if traces.server is not None:
        yield from _server_steps(types, traces.server, traces, start)
        if traces.server.scene:
            yield 0, SCENE, types.String(data=json.dumps(traces.server.scene))
    for packets in traces.packets.values():
        yield from _packets(types, packets, scenario, start)
    end_ns = _ns(traces.duration_s)
    for number, (link, received) in enumerate(traces.receptions.items()):
        owner, _, way = link.rpartition("/")
        at_server = way == "up"
        seq, epoch = (1 + number // 2, SERVER_EPOCH) if at_server else (1, _epoch(traces, owner))
        stamp = build.time_message(types, start + end_ns)
        head = {"stamp": stamp, "epoch": epoch, "seq": seq, "link": link, "sender": 0}
        message = types.Reception(**head, **received.counts, **received.passage)
        yield end_ns, f"/{'server' if at_server else owner}/reception", message
    for fates in traces.fates.values():  # packets still in flight at the end never came out
        out_ns = np.where(fates.time_out_ns < end_ns, fates.time_out_ns, 0)
        yield from fate_blocks(types, replace(fates, time_out_ns=out_ns), start)


def _epoch(traces: SessionTraces, name: str) -> int:
    """Return the epoch of a user's packets, as its trace carries it, too."""
    return 1 + [user.name for user in traces.users].index(name)


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)


def _master_blocks(
    types: MessageTypes, user: UserTraces, traces: SessionTraces, start: int
) -> Iterator[Outgoing]:
    epoch, received = _epoch(traces, user.name), traces.taken.get(f"{user.name}/down")
    edges = [0, *user.block_ends.tolist()]
    signals = {name: getattr(user, trace) for name, trace in TRACES.items()}
    signals |= {"lateness": user.lateness_s, "compute": user.compute_s}
    signals |= {"looked": user.looked_ns}
    known = bool(np.isfinite(user.f_h).all())
    for block, (first, after) in enumerate(itertools.pairwise(edges)):
        at_ns, last = _ns(user.time_s[first]), block == len(edges) - 2
        message = build.master_trace(
            types, {name: array[first:after].ravel() for name, array in signals.items()},
            taken=_taken(received, first, after), stamp_ns=start + at_ns, start_ns=at_ns,
            changes=int(user.changes[block]) if len(user.changes) else 0, epoch=epoch,
            seq=block + 1, first_tick=int(user.tick[first]), period=user.tick_s,
            dof=user.x_m.shape[-1], state=int(user.state[block]), reason=user.reason[block],
            missed=user.missed if last else 0, hand_force_known=known,
            safety_events=int(user.safety_events) if last else 0,
            energy={name: sums[block] for name, sums in user.energy.items()},
            accounts={name: sums[block] for name, sums in user.accounts.items()},
            orientation=user.orientation[block] if len(user.orientation) else (),
        )  # fmt: skip
        yield _ns(user.block_time_s[block]), f"/{user.name}/trace", message


def _server_steps(
    types: MessageTypes, server: ServerTraces, traces: SessionTraces, start: int
) -> Iterator[Outgoing]:
    late_s = traces.metadata.get("server_lateness_s", np.zeros(len(server.time_s)))
    received = [traces.taken.get(f"{name}/up") for name in server.users]
    for row, time_s in enumerate(server.time_s):
        fields: dict[str, Any] = {
            name: [a[row] for a in getattr(server, name)] for name in OF_USERS
        }
        fields |= {name: getattr(server, name)[row] for name in OF_STEP}
        inside = slice(*np.searchsorted(server.contacts[:, 0], [row, row + 1]))
        message = build.server_trace(
            types, stamp_ns=start + _ns(time_s), start_ns=_ns(time_s), epoch=SERVER_EPOCH,
            step=int(server.step[row]), period=float(server.periods_s[row]),
            dof=server.x_o.shape[-1], users=server.users,
            taken=[
                (user, *packet[1:])
                for user, each in enumerate(received)
                for packet in _taken(each, row, row + 1)
            ],
            looked=int(server.looked_ns[row]),
            changes=int(server.changes[row]) if len(server.changes) else 0,
            contained=int(server.contained[row]) if len(server.contained) else 0,
            accounts={name: sums[row] for name, sums in server.accounts.items()},
            poses={name: rows[row] for name, rows in server.poses.items()},
            contacts=server.contacts[inside, 1:].ravel().tolist(),
            lateness=float(late_s[row]), **fields,
        )  # fmt: skip
        yield _ns(time_s), "/server/trace", message


def _packets(
    types: MessageTypes, packets: PacketTraces, scenario: Scenario, start: int
) -> Iterator[Outgoing]:
    flags = 0 if has_waves(scenario.controller) else FLAG_DIRECT
    numbers = (packets.epoch, packets.seq, packets.sent_ns, packets.period_s, packets.energy)
    columns = (each.tolist() for each in numbers)
    signals = packets.wave, packets.integral, packets.position, packets.orientation
    for time_s, epoch, seq, sent_ns, period, energy, wave, integral, position, orientation in zip(
        packets.time_s, *columns, *signals, strict=True
    ):
        content = epoch, seq, sent_ns, period, wave, integral, energy, position
        packet = WavePacket(*content, flags=flags, orientation=orientation)
        message = build.wave(types, packet, start + packet.sent_ns)
        yield _ns(time_s), packets.topic, message


def _taken(taken: TakenTraces | None, first: int, after: int) -> list[tuple[int, int, int]]:
    """Return row, number and sender's epoch of what was taken in by rows of the traces; rows count
    from the first of them.
    """
    if taken is None:
        return []
    inside = slice(*np.searchsorted(taken.row, [first, after]))
    columns = taken.row[inside] - first, taken.seq[inside], taken.epoch[inside]
    return list(zip(*(column.tolist() for column in columns), strict=True))
