# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sequence numbers of messages, and the count of missing ones.

Each publisher numbers what it sends: packets and blocks by ``seq``, server steps by ``step``,
fates by the number of their first record. A number that never came, between the first and the last
that did, is missing; the first one of a publisher started while recording is 1, so what was lost
before it counts too.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pmwvc_analysis.recording import schemas

MOST_STREAMS = 64  # publishers of one topic whose numbers are followed


@dataclass(frozen=True, slots=True)
class Numbered:
    """Numbers of a message: publisher (epoch or link), and ``count`` numbers from ``first`` on."""

    stream: str
    first: int
    count: int = 1


def numbered(type_name: str, message: Any) -> Numbered:
    """Return the numbers of a message of a session."""
    if type_name == schemas.PACKET_FATE:
        return Numbered(str(message.link), int(message.first), len(message.seq))
    number = message.step if type_name == schemas.SERVER_TRACE else message.seq
    return Numbered(f"{int(message.epoch):016x}", int(number))


@dataclass
class StreamCount:
    """The numbers of one publisher on one topic: how many were ``seen``, and the ``newest``.

    One that comes again counts again: only an emulated link delivers a packet twice, and behind
    one its fates tell what is missing.
    """

    seen: int = 0
    newest: int = 0

    def add(self, first: int, count: int) -> None:
        """Add consecutive numbers."""
        self.seen += count
        self.newest = max(self.newest, first + count - 1)

    @property
    def missing(self) -> int:
        """Count of numbers from 1 to the newest that never arrived."""
        return max(self.newest - self.seen, 0)


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
