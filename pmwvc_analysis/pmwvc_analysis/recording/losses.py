# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages missing in a recording, separated from those that the emulated network lost.

On a topic that a node publishes itself, a number that is not in the file was not recorded. Behind
an emulated link a number may be absent because the link lost the packet: there, what the link
reports it delivered is compared with what is in the file. And a packet that was sent, and of which
the link knows nothing, never reached it: its two ends had not met.
"""

from collections.abc import Mapping

import numpy as np

from pmwvc_analysis.recording.format.topics import relayed, source_of
from pmwvc_analysis.recording.sequence import GapCounter
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.numeric import Flags
from pmwvc_core.traces import FateTraces, PacketTraces

DROPPED = (FateKind.DROPPED_RATE, FateKind.DROPPED_QUEUE)


def came_out(fates: FateTraces) -> Flags:
    """Tell which packets and copies came out of a link."""
    kinds = (FateKind.DELIVERED, FateKind.DUPLICATE)
    return np.isin(fates.fate, kinds) & (fates.time_out_ns > 0)


def topic_counts(
    counter: GapCounter, fates: Mapping[str, FateTraces], packets: Mapping[str, PacketTraces]
) -> dict[str, dict[str, int]]:
    """Return ``messages``, ``missing`` and, where there are any, ``not_relayed`` by topic."""
    counts: dict[str, dict[str, int]] = {}
    for topic, messages in counter.messages.items():
        origin = relayed(topic)
        if origin is not None and origin[0] in fates:
            missing = _not_recorded(packets.get(topic), fates[origin[0]])
        else:
            missing = counter.missing(topic)
        counts[topic] = {"messages": messages, "missing": missing}
    for link, known in fates.items():
        source = source_of(link)
        if source in packets and (count := not_relayed(packets[source], known)[0]):
            counts[source]["not_relayed"] = count
    return counts


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
