# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What is missing in a recording, told apart from what the emulated network lost.

On a topic that a node publishes itself, a number that is not in the file was not recorded. Behind
an emulated link a number may be absent because the link lost the packet: there, what the link says
it delivered is compared with what is in the file.
"""

from collections.abc import Mapping

import numpy as np

from pmwvc_analysis.recording.sequence import GapCounter
from pmwvc_analysis.recording.topics import relayed
from pmwvc_core.simulation.traces import FateTraces

# The numbers of PacketFate.msg.
DELIVERED, LOST, DUPLICATE = 0, 1, 2
DROPPED = (3, 4)  # by the rate limit, by a full queue


def delivered_numbers(fates: FateTraces) -> dict[str, set[int]]:
    """Return per sender (epoch, as in sequence.py) the packet numbers that came out of a link."""
    out = np.isin(fates.fate, (DELIVERED, DUPLICATE)) & (fates.time_out_ns > 0)
    numbers: dict[str, set[int]] = {}
    for epoch in np.unique(fates.epoch):
        own = out & (fates.epoch == epoch)
        numbers[f"{int(epoch):016x}"] = {int(seq) for seq in fates.seq[own]}
    return numbers


def topic_counts(
    counter: GapCounter, fates: Mapping[str, FateTraces]
) -> dict[str, dict[str, int]]:
    """Return ``{"messages": int, "missing": int}`` per topic."""
    counts = {}
    for topic, messages in counter.messages.items():
        origin = relayed(topic)
        if origin is not None and origin[0] in fates:
            missing = _not_recorded(counter, topic, fates[origin[0]])
        else:
            missing = counter.missing(topic)
        counts[topic] = {"messages": messages, "missing": missing}
    return counts


def _not_recorded(counter: GapCounter, topic: str, fates: FateTraces) -> int:
    """Return how many packets a link delivered that the file does not hold."""
    missing = 0
    for epoch, numbers in delivered_numbers(fates).items():
        stream = counter.streams.get(topic, {}).get(epoch)
        ranges = stream.ranges if stream is not None else []
        recorded = {number for first, after in ranges for number in range(first, after)}
        missing += len(numbers - recorded)
    return missing
