# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages of emulated links and of receivers: their traces, the messages that an emulator
would have published of packet fates, and what is missing in a recording apart from what the links
lost.

On a topic that a node publishes itself, a number that is not in the file was not recorded. Behind
an emulated link a number may be absent because the link lost the packet: there, what the link
reports it delivered is compared with what is in the file.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.recording.content import Content
from pmwvc_analysis.recording.topics import relayed
from pmwvc_core.network.in_flight import COLUMNS as PUBLISHED
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.numeric import Flags
from pmwvc_core.runtime import messages as build
from pmwvc_core.runtime.messages import MessageTypes, nanoseconds
from pmwvc_core.runtime.misfits import PacketFate, Reception
from pmwvc_core.traces import FateTraces, PacketTraces, ReceptionTraces
from pmwvc_core.transport.receiver import PASSAGE, REFUSED

BLOCK_NS = 500_000_000
Outgoing = tuple[int, str, Any]  # time on the session's time line [ns], topic, message
COLUMNS = {name: name for name in PUBLISHED} | {"bytes": "size_bytes"}
RECEIVED = ("accepted", "beginnings", "lost", "duplicate", "reordered", *REFUSED)
DROPPED = (FateKind.DROPPED_RATE, FateKind.DROPPED_QUEUE)


def fate_blocks(types: MessageTypes, fates: FateTraces, start: int) -> Iterator[Outgoing]:
    """Yield PacketFate messages of half a second, each at the time of its last packet."""
    blocks = fates.time_in_ns // BLOCK_NS
    edges = [0, *(np.flatnonzero(np.diff(blocks)) + 1).tolist(), len(blocks)]
    for first, after in itertools.pairwise(edges):
        if first == after:
            continue
        columns = {field: getattr(fates, name)[first:after] for field, name in COLUMNS.items()}
        at_ns = int(columns["time_in_ns"].max())
        head: dict[str, Any] = {"stamp_ns": start + at_ns, "link": fates.link, "first": first + 1}
        yield at_ns, "/netem/fates", build.packet_fates(types, **head, **columns)


def reordered(fates: FateTraces) -> Flags:
    """Tell which records left the link after a later packet of the same sender had left."""
    result = np.zeros(len(fates.seq), dtype=np.bool_)
    for epoch in np.unique(fates.epoch):
        rows = np.flatnonzero((fates.epoch == epoch) & (fates.time_out_ns > 0))
        rows = rows[np.argsort(fates.time_out_ns[rows], kind="stable")]
        result[rows] = fates.seq[rows] < np.maximum.accumulate(fates.seq[rows])
    return result


def fate_traces(link: str, messages: Sequence[PacketFate]) -> FateTraces:
    """Return the fate of each packet of a link, blocks in order and repeated ones left out."""
    blocks = dict(sorted({int(message.first): message for message in messages}.items()))
    numbers = [np.arange(len(block.seq), dtype=np.int64) + n for n, block in blocks.items()]
    columns: dict[str, Any] = {}
    for field, name in COLUMNS.items():
        values = np.concatenate([getattr(block, field) for block in blocks.values()])
        columns[name] = values.astype(np.uint64 if name == "epoch" else np.int64)
    return FateTraces(link=link, number=np.concatenate(numbers), **columns)


def reception_traces(link: str, messages: Sequence[Reception]) -> ReceptionTraces:
    """Return the last report of each start of a receiver, added up."""
    last = {int(message.epoch): message for message in sorted(messages, key=lambda m: m.seq)}
    names = (*RECEIVED, "other_controller")
    counts = {name: sum(int(getattr(m, name)) for m in last.values()) for name in names}
    known = [message for message in messages if math.isfinite(message.round_trip)]
    newest = max(known, key=lambda each: nanoseconds(each.stamp), default=None)
    passage = {name: float(getattr(newest, name, math.nan)) for name in PASSAGE}
    return ReceptionTraces(link, receivers=len(last), counts=counts, passage=passage)


def fate_zeros(of_links: Mapping[str, Sequence[PacketFate]], zero_ns: int) -> dict[str, int]:
    """Return the start of the session on the monotonic clock of each link's emulator [ns].

    A block is published after its last packet came in: the least difference is the clocks'.
    """
    found = {}
    for link, messages in of_links.items():
        blocks = [(nanoseconds(m.stamp), m.time_in_ns) for m in messages if len(m.time_in_ns)]
        if blocks:
            found[link] = zero_ns - min(at_ns - int(times_ns.max()) for at_ns, times_ns in blocks)
    return found


def came_out(fates: FateTraces) -> Flags:
    """Tell which packets and copies came out of a link."""
    return np.isin(fates.fate, (FateKind.DELIVERED, FateKind.DUPLICATE)) & (fates.time_out_ns > 0)


def topic_counts(
    content: Content, fates: Mapping[str, FateTraces], packets: Mapping[str, PacketTraces]
) -> dict[str, dict[str, int]]:
    """Return ``messages`` and ``missing`` by topic."""
    counts: dict[str, dict[str, int]] = {}
    for topic, messages in content.messages.items():
        missing = sum(missing for missing, _ in content.gaps(topic).values())
        if known := fates.get(relayed(topic) or ""):
            whole = came_out(known) & (known.cause != Cause.CORRUPTION)
            delivered = {*zip(known.epoch[whole].tolist(), known.seq[whole].tolist(), strict=True)}
            if (here := packets.get(topic)) is not None:
                delivered -= {*zip(here.epoch.tolist(), here.seq.tolist(), strict=True)}
            missing = len(delivered)
        counts[topic] = {"messages": messages, "missing": missing}
    return counts
