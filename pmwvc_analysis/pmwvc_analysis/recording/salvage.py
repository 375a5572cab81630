# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""MCAP files from front to back: the messages as far as a file is whole, and the check that it is.

A killed recorder leaves a file without index and footer, often cut in the middle of a record.
Everything up to the last whole chunk is there, each chunk guarded by its checksum. The library
checks chunks and the data section; here what the summary counts is checked. Its indexes, which
nothing here reads, are not.
"""

import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import BinaryIO, NamedTuple

from mcap import records as mcap
from mcap.exceptions import EndOfFile, McapError
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk
from zstandard import ZstdError

# What the library raises where a file is damaged.
DAMAGE = (McapError, CRCValidationError, ZstdError, struct.error, ValueError, RuntimeError)


class RawMessage(NamedTuple):
    """One serialized message with its channel and times [ns]."""

    topic: str
    type_name: str
    log_ns: int
    publish_ns: int
    data: bytes


@dataclass
class Salvage:
    """Everything else in a file, filled while its messages are iterated."""

    schemas: dict[str, str] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    topics: dict[str, None] = field(default_factory=dict)
    messages: int = 0
    chunks: int = 0
    end: str | None = None  # why the file ends early; None: it is complete
    problems: list[str] = field(default_factory=list)  # why it is not whole

    @property
    def whole(self) -> bool:
        """Tell whether nothing is wrong."""
        return not self.problems


def messages(stream: BinaryIO, salvage: Salvage) -> Iterator[RawMessage]:
    """Yield every message of every whole chunk of an open file, then close it; ``salvage`` holds
    how far it was good.
    """
    channels: dict[int, mcap.Channel] = {}
    names: dict[int, str] = {}
    counts: Counter[int] = Counter()  # messages by channel
    try:
        for record in _records(stream, salvage, counts):
            match record:
                case mcap.Schema(id=number, name=name, data=text):
                    names[number] = name
                    salvage.schemas[name] = text.decode("utf-8", "replace")
                case mcap.Channel():
                    channels[record.id] = record
                    salvage.topics[record.topic] = None
                case mcap.Message(channel_id=number, log_time=log_ns, publish_time=publish_ns):
                    counts[number] += 1
                    if (channel := channels.get(number)) is None:
                        what = f"messages of channel {number}, which is defined nowhere before"
                        salvage.problems += [] if what in salvage.problems else [what]
                        continue
                    salvage.messages += 1
                    name = names.get(channel.schema_id, "")
                    yield RawMessage(channel.topic, name, log_ns, publish_ns, record.data)
    except DAMAGE as error:
        cut = isinstance(error, (EndOfFile, struct.error))
        why = "cut in the middle of a record" if cut else str(error) or type(error).__name__
        salvage.end = f"{why}, at byte {stream.tell()}"
        salvage.problems.append(f"{salvage.end}: the file is damaged, or it was not closed")
    finally:
        stream.close()


def _records(
    stream: BinaryIO, salvage: Salvage, counts: Counter[int]
) -> Iterator[mcap.McapRecord]:
    """Yield the definitions and messages of a file; check it, ``counts`` the messages so far."""
    for record in StreamReader(stream, emit_chunks=True, validate_crcs=True).records:
        match record:
            case mcap.Chunk():
                salvage.chunks += 1
                yield from breakup_chunk(record, validate_crc=True)
            case mcap.Metadata():
                salvage.metadata[record.name] = record.metadata
            case mcap.Statistics(channel_message_counts=stated, chunk_count=chunks):
                if (Counter(stated), chunks) != (counts, salvage.chunks):
                    salvage.problems.append("the statistics do not fit what is in the file")
            case _:
                yield record
    if stream.read(1):
        salvage.problems.append("bytes follow the end of the file")
