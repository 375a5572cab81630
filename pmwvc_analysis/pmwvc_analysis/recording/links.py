# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages of emulated links and of receivers: their traces, the messages that an emulator
would have published of packet fates, and what is missing in a recording apart from what the links
lost.

On a topic that a node publishes itself, a number that is not in the file was not recorded. Behind
an emulated link a number may be absent because the link lost the packet: there, what the link
reports it delivered is compared with what is in the file. And a packet that was sent, and of which
the link knows nothing, never reached it: its two ends had not met.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.recording import clocks
from pmwvc_analysis.recording.sequence import GapCounter
from pmwvc_analysis.recording.topics import relayed, source_of
from pmwvc_core.network.in_flight import COLUMNS as PUBLISHED
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.params import LinkParams
from pmwvc_core.runtime import messages as build
from pmwvc_core.runtime.messages import MessageTypes, nanoseconds
from pmwvc_core.runtime.misfits import LinkState, PacketFate, Reception
from pmwvc_core.traces import FateTraces, PacketTraces, ReceptionTraces
from pmwvc_core.transport.receiver import PASSAGE, REFUSED

BLOCK_NS = 500_000_000
STATE_NS = 1_000_000_000
COLUMNS = {name: name for name in PUBLISHED} | {"bytes": "size_bytes"}
_RECEIVED = ["accepted", "beginnings", "lost", "duplicate", "reordered", *REFUSED]
_RECEIVED.append("other_controller")


def fate_blocks(types: MessageTypes, fates: FateTraces, start: int) -> Iterator[tuple[int, Any]]:
    """Yield PacketFate messages of half a second with the time of the last packet in each [ns]."""
    blocks = fates.time_in_ns // BLOCK_NS
    edges = [0, *(np.flatnonzero(np.diff(blocks)) + 1).tolist(), len(blocks)]
    for first, after in itertools.pairwise(edges):
        if first == after:
            continue
        columns = {field: getattr(fates, name)[first:after] for field, name in COLUMNS.items()}
        at_ns = int(columns["time_in_ns"].max())
        head: dict[str, Any] = {"stamp_ns": start + at_ns, "link": fates.link, "first": first + 1}
        yield at_ns, build.packet_fates(types, **head, **columns)


def state_blocks(
    types: MessageTypes, fates: FateTraces, params: LinkParams, start: int, *, seed: int
) -> Iterator[tuple[int, Any]]:
    """Yield one LinkState message a second, with its time [ns]."""
    if not len(fates.number):
        return
    out = fates.time_out_ns > 0
    delays = (fates.time_out_ns - fates.time_in_ns) * 1e-9
    overtaken = reordered(fates)
    end = int(max(fates.time_in_ns.max(), fates.time_out_ns.max()))
    for seq, at_ns in enumerate(range(STATE_NS, end + STATE_NS, STATE_NS), start=1):
        came, left = fates.time_in_ns < at_ns, out & (fates.time_out_ns < at_ns)
        recent = left & (fates.time_out_ns >= at_ns - STATE_NS)
        now = delays[recent] if recent.any() else np.zeros(1)
        kinds = fates.fate[came]
        counts = {
            "in_count": int((came & (fates.fate != FateKind.DUPLICATE)).sum()),
            "out_count": int(left.sum()),
            "lost": int((kinds == FateKind.LOST).sum()),
            "duplicated": int((kinds == FateKind.DUPLICATE).sum()),
            "reordered": int((overtaken & left).sum()),
            "corrupted": int((fates.cause[came] == Cause.CORRUPTION).sum()),
            "queued": int((came & out).sum() - left.sum()),
            "dropped": int(np.isin(kinds, DROPPED).sum()),
        }
        figures = {"delay_mean": now.mean(), "delay_min": now.min(), "delay_max": now.max()}
        message = build.link_state(
            types,
            stamp_ns=start + at_ns,
            link=fates.link,
            seq=seq,
            counts=counts,
            delays={"delay_error_max": 0.0} | {name: float(d) for name, d in figures.items()},
            rate_hz=float(recent.sum()) * 1e9 / STATE_NS,
            params=params,
            seed=seed,
        )
        yield at_ns, message


def reordered(fates: FateTraces) -> Flags:
    """Tell which records left the link after a later packet of the same sender had left."""
    result = np.zeros(len(fates.seq), dtype=np.bool_)
    for epoch in np.unique(fates.epoch):
        rows = np.flatnonzero((fates.epoch == epoch) & (fates.time_out_ns > 0))
        rows = rows[np.argsort(fates.time_out_ns[rows], kind="stable")]
        newest = np.maximum.accumulate(fates.seq[rows])
        result[rows] = fates.seq[rows] < newest
    return result


def fate_traces(link: str, messages: Sequence[PacketFate]) -> FateTraces:
    """Return the fate of each packet of a link, blocks in order and repeated ones left out."""
    blocks = list({int(m.first): m for m in sorted(messages, key=lambda m: int(m.first))}.values())
    numbers = [np.arange(len(b.seq), dtype=np.int64) + int(b.first) for b in blocks]
    columns: dict[str, Any] = {}
    for field, name in COLUMNS.items():
        values = np.concatenate([np.asarray(getattr(block, field)) for block in blocks])
        columns[name] = values.astype(np.uint64 if name == "epoch" else np.int64)
    return FateTraces(link=link, number=np.concatenate(numbers), **columns)


def link_states(messages: Sequence[LinkState], *, zero_ns: int) -> dict[str, Array]:
    """Return counts, delays and settings of a link over time, by the names of LinkState."""
    stamps = clocks.stamps(messages)
    order = np.argsort(stamps, kind="stable")
    fields = vars(messages[0]).items()
    names = [name for name, value in fields if isinstance(value, int | float)]
    columns = {n: np.array([getattr(m, n) for m in messages], dtype=float)[order] for n in names}
    return {"time_s": clocks.seconds(stamps[order], zero_ns)} | columns


def reception_traces(link: str, messages: Sequence[Reception]) -> ReceptionTraces:
    """Return the last report of each start of a receiver, added up."""
    last = {int(message.epoch): message for message in sorted(messages, key=lambda m: m.seq)}
    passage = dict.fromkeys(PASSAGE, math.nan)
    for message in sorted(messages, key=lambda each: nanoseconds(each.stamp)):
        values = {name: float(getattr(message, name)) for name in PASSAGE}
        if math.isfinite(values["round_trip"]):
            passage = values
    counts = {name: sum(int(getattr(m, name)) for m in last.values()) for name in _RECEIVED}
    return ReceptionTraces(link, receivers=len(last), counts=counts, passage=passage)


def fate_zeros(of_links: Mapping[str, Sequence[PacketFate]], zero_ns: int) -> dict[str, int]:
    """Return the start of the session on the monotonic clock of each link's emulator [ns].

    A block is published after its last packet came in: the least difference is the clocks'.
    """
    found = {}
    for link, messages in of_links.items():
        if blocks := [message for message in messages if len(message.time_in_ns)]:
            last_in = np.array([int(np.max(block.time_in_ns)) for block in blocks])
            found[link] = zero_ns - int(np.min(clocks.stamps(blocks) - last_in))
    return found


DROPPED = (FateKind.DROPPED_RATE, FateKind.DROPPED_QUEUE)


def came_out(fates: FateTraces) -> Flags:
    """Tell which packets and copies came out of a link."""
    kinds = (FateKind.DELIVERED, FateKind.DUPLICATE)
    return np.isin(fates.fate, kinds) & (fates.time_out_ns > 0)


def topic_counts(
    counter: GapCounter, fates: Mapping[str, FateTraces], packets: Mapping[str, PacketTraces]
) -> tuple[dict[str, dict[str, int]], list[dict[str, Any]]]:
    """Return ``messages``, ``missing`` and, where there are any, ``not_relayed`` by topic, and as
    events which packets never reached their link.
    """
    counts: dict[str, dict[str, int]] = {}
    for topic, messages in counter.messages.items():
        known = fates.get(relayed(topic) or "")
        missing = _not_recorded(packets.get(topic), known) if known else counter.missing(topic)
        counts[topic] = {"messages": messages, "missing": missing}
    events: list[dict[str, Any]] = []
    for link, known in fates.items():
        if (sent := packets.get(source_of(link))) is None or not len(known.seq):
            continue
        count, first = not_relayed(sent, known)
        if count:
            counts[sent.topic]["not_relayed"] = count
            time_s = float(sent.time_s[np.argmax(sent.seq == first)])
            what = f"{count} packets of {sent.topic} never reached it, from number {first} on"
            events.append({"time_s": time_s, "who": link, "kind": "link", "what": what})
    return counts, events


def not_relayed(packets: PacketTraces, fates: FateTraces) -> tuple[int, int]:
    """Return how many packets of a topic never reached the link behind it, and the first of them.

    Judged are those up to the last one that the link knows of each sender. Records of fates that
    are missing themselves may have been of such packets: these are not counted.
    """
    absent: list[int] = []
    for epoch in np.unique(fates.epoch):
        known = fates.seq[fates.epoch == epoch]
        sent = packets.seq[packets.epoch == epoch]
        sent = sent[sent <= known.max()]
        absent += np.setdiff1d(sent, known).tolist()
    unknown = int(fates.number[-1]) - len(fates.number) if len(fates.number) else 0
    return max(len(absent) - unknown, 0), min(absent, default=0)


def _not_recorded(packets: PacketTraces | None, fates: FateTraces) -> int:
    """Return how many packets a link delivered whole that the file does not hold."""
    out, missing = came_out(fates) & (fates.cause != Cause.CORRUPTION), 0
    for epoch in np.unique(fates.epoch):
        numbers = fates.seq[out & (fates.epoch == epoch)]
        recorded = [] if packets is None else packets.seq[packets.epoch == epoch]
        missing += len(np.setdiff1d(numbers, recorded))
    return missing
