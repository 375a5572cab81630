# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sequence numbers of messages, and the count of missing ones.

Each publisher numbers what it sends: packets and blocks by ``seq``, server steps by ``step``,
fates by the number of their first record. A number that never came, between the first and the last
that did, is missing; the first one of a publisher started while recording is 1, so what was lost
before it counts too.
"""

from collections import Counter
from collections.abc import Iterable
from typing import Any, NamedTuple

from pmwvc_analysis.recording import schemas


class Numbered(NamedTuple):
    """Numbers of a message: publisher (epoch or link), and ``many`` numbers from ``first`` on."""

    stream: str
    first: int
    many: int = 1


def numbered(type_name: str, message: Any) -> Numbered:
    """Return the numbers of a message of a session."""
    if type_name == schemas.PACKET_FATE:
        return Numbered(str(message.link), int(message.first), len(message.seq))
    number = message.step if type_name == schemas.SERVER_TRACE else message.seq
    return Numbered(f"{int(message.epoch):016x}", int(number))


class Gap(NamedTuple):
    """How many numbers of a publisher never came, and how many did. One that comes again counts
    again: only an emulated link delivers a packet twice, and its fates tell what is missing.
    """

    missing: int
    seen: int


def gaps(numbers: Iterable[Numbered]) -> dict[str, Gap]:
    """Return the gaps of every publisher of a topic, by its name."""
    seen: Counter[str] = Counter()
    newest: dict[str, int] = {}
    for stream, first, many in numbers:
        seen[stream] += many
        newest[stream] = max(newest.get(stream, 0), first + many - 1)
    return {stream: Gap(max(newest[stream] - n, 0), n) for stream, n in seen.items()}
