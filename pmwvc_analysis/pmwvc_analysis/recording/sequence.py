# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sequence numbers of messages, and the count of missing ones.

Each publisher numbers what it sends: packets and blocks by ``seq``, server steps by ``step``,
fates by the number of their first record. A number that never came, between the first and the last
that did, is missing; the first one of a publisher started while recording is 1, so what was lost
before it counts too.
"""

import bisect
import struct
from collections.abc import Iterable
from dataclasses import dataclass, field

from pmwvc_analysis.recording import schemas

MOST_RANGES = 256  # of one publisher: hours of losses take no memory
MOST_STREAMS = 64  # publishers of one topic whose numbers are followed
_EPOCH_NUMBER = {  # behind the stamp, and the clock where a type has one
    schemas.WAVE: struct.Struct("<16xQI"),
    schemas.MASTER_TRACE: struct.Struct("<16xQI"),
    schemas.SERVER_TRACE: struct.Struct("<16xQQ"),
    schemas.RECEPTION: struct.Struct("<8xQI"),
}
_LENGTH = struct.Struct("<8xI")  # of the link's name, behind the stamp
_FATES = struct.Struct("<QI")  # behind the name: number of the first one and how many


@dataclass(frozen=True, slots=True)
class Numbered:
    """Numbers of a message: publisher (epoch or link), and ``count`` numbers from ``first`` on."""

    stream: str
    first: int
    count: int = 1


def peek(type_name: str, data: bytes) -> Numbered | None:
    """Return the numbers of a serialized message, or None: another type, or not a whole message.

    Offsets follow from the field order in the ``.msg`` files: the numbers come right after the
    stamps. The recorder has no time to decode messages.
    """
    body = data[4:]  # behind the encapsulation
    try:
        if (layout := _EPOCH_NUMBER.get(type_name)) is not None:
            epoch, number = layout.unpack_from(body)
            return Numbered(f"{epoch:016x}", number)
        if type_name != schemas.PACKET_FATE:
            return None
        (length,) = _LENGTH.unpack_from(body)
        end = _LENGTH.size + length
        link = body[_LENGTH.size : max(end - 1, _LENGTH.size)].decode("utf-8", "replace")
        return Numbered(link, *_FATES.unpack_from(body, end + -end % 8))
    except struct.error:
        return None


@dataclass
class StreamCount:
    """The numbers seen of one publisher on one topic, as merged ranges ``[first, after)``.

    Of many ranges the oldest are joined; what is missing between them stays counted.
    """

    ranges: list[list[int]] = field(default_factory=list)
    settled: int = 0  # missing numbers in the first range

    def add(self, first: int, count: int) -> None:
        """Add consecutive numbers; in order is the fast case."""
        after = first + count
        if self.ranges and first == self.ranges[-1][1]:
            self.ranges[-1][1] = after
            return
        touching = [old for old in self.ranges if old[0] <= after and first <= old[1]]
        whole = [first, after], *touching
        self.ranges = [old for old in self.ranges if old not in touching]
        bisect.insort(self.ranges, [min(of[0] for of in whole), max(of[1] for of in whole)])
        if len(self.ranges) > MOST_RANGES:
            (first, end), (begin, after) = self.ranges[:2]
            self.settled += begin - end
            self.ranges[:2] = [[first, after]]

    @property
    def missing(self) -> int:
        """Count of numbers from 1 to the last seen that never arrived."""
        ends = [1, *(after for _, after in self.ranges)]
        gaps = (max(first - end, 0) for (first, _), end in zip(self.ranges, ends, strict=False))
        return self.settled + sum(gaps)

    @property
    def seen(self) -> int:
        """Count of different numbers that arrived."""
        return self.ranges[-1][1] - 1 - self.missing if self.ranges else 0


class GapCounter:
    """Messages and missing numbers per topic and publisher."""

    def __init__(self) -> None:
        self.messages: dict[str, int] = {}
        self.streams: dict[str, dict[str, StreamCount]] = {}

    def add(self, topic: str, numbers: Numbered | None) -> None:
        """Count one message; ``numbers`` is None where it carries no number."""
        self.messages[topic] = self.messages.get(topic, 0) + 1
        if numbers is not None:
            streams = self.streams.setdefault(topic, {})
            if numbers.stream in streams or len(streams) < MOST_STREAMS:
                streams.setdefault(numbers.stream, StreamCount()).add(numbers.first, numbers.count)

    def topic(self, name: str) -> None:
        """Name a topic that is expected, so that it is counted even when nothing comes."""
        self.messages.setdefault(name, 0)

    def missing(self, topic: str) -> int:
        """Return how many numbers are missing on a topic, over all publishers."""
        return sum(stream.missing for stream in self.streams.get(topic, {}).values())

    def lines(self, topics: Iterable[str] | None = None) -> list[str]:
        """Return one line of text per topic and publisher where numbers are missing."""
        return [
            f"{topic}: {stream.missing} of {stream.missing + stream.seen} missing "
            f"(publisher {name})"
            for topic in (self.streams if topics is None else topics)
            for name, stream in self.streams.get(topic, {}).items()
            if stream.missing
        ]
