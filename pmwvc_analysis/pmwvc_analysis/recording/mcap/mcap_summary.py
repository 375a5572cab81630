# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The summary section of an MCAP file against what its data section was seen to hold."""

import itertools
import zlib
from collections import Counter
from dataclasses import dataclass, field

from pmwvc_analysis.recording.mcap import mcap_records as mcap

ChunkFacts = tuple[
    int, int, int, str, int, int
]  # first, last, size, compression, packed, unpacked


@dataclass
class Seen:
    """What the data section holds, collected while it is checked, and everything wrong so far."""

    problems: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    schemas: dict[int, bytes] = field(default_factory=dict)
    channels: dict[int, bytes] = field(default_factory=dict)
    messages: Counter[int] = field(default_factory=Counter)
    first_ns: int | None = None
    last_ns: int = 0
    metadata: int = 0
    attachments: int = 0
    # name of a metadata record; times, size, name and kind of an attachment; by offset
    described: dict[int, tuple[int | str, ...]] = field(default_factory=dict)
    offsets: dict[int, mcap.Record] = field(default_factory=dict)
    chunks: dict[int, ChunkFacts] = field(default_factory=dict)
    chunk_indexes: dict[int, dict[int, mcap.Record]] = field(default_factory=dict)
    in_chunk: dict[int, set[tuple[int, int]]] = field(default_factory=dict)  # of the newest chunk
    indexed: dict[int, mcap.Record] = field(default_factory=dict)

    def problem(self, text: str) -> None:
        """Note what is wrong."""
        self.problems.append(text)

    def message(self, channel: int, log_time: int) -> None:
        """Count a message."""
        self.messages[channel] += 1
        self.first_ns = log_time if self.first_ns is None else min(self.first_ns, log_time)
        self.last_ns = max(self.last_ns, log_time)


def check_summary(data: memoryview, start: int, end: int, seen: Seen) -> None:
    """Check everything behind the data-end record."""
    found = list(mcap.records(data, start, end))
    if not found or found[-1].opcode != mcap.FOOTER:
        raise mcap.Malformed("the file does not end with a footer")
    *summary, footer = found
    summary_start, offset_start, crc = footer.fields().numbers(8, 8, 4)
    if footer.size != mcap.PREFIX + 20:
        seen.problem("the footer has another size than it should")
    if summary_start != (start if summary else 0):
        seen.problem(f"the footer says the summary starts at byte {summary_start}, not {start}")
    if crc == 0:
        seen.notes.append("no checksum of the summary")
    elif crc != zlib.crc32(data[start : footer.end - 4]):
        seen.problem("the checksum of the summary is wrong")
    offsets = [record for record in summary if record.opcode == mcap.SUMMARY_OFFSET]
    if offset_start != (offsets[0].offset if offsets else 0):
        seen.problem(f"the footer says the summary offsets start at byte {offset_start}")
    indexes = _check_records(summary, seen)
    if seen.chunks and indexes and indexes != set(seen.chunks):
        seen.problem(f"{len(set(seen.chunks) - indexes)} chunks have no index in the summary")
    _check_offsets(summary, seen)


def _check_records(summary: list[mcap.Record], seen: Seen) -> set[int]:
    """Check each record of the summary; return the offsets of the chunks that are indexed."""
    indexed: set[int] = set()
    # by opcode: schemas and channels before the statistics that count them
    for record in sorted(summary, key=lambda record: record.opcode):
        if record.opcode in (mcap.SCHEMA, mcap.CHANNEL):
            known = seen.schemas if record.opcode == mcap.SCHEMA else seen.channels
            number = record.fields().number(2)
            # one without messages may stand in the summary only
            if number in known and known[number] != bytes(record.content):
                seen.problem(f"{mcap.name_of(record.opcode)} {number} differs in the summary")
            known.setdefault(number, bytes(record.content))
        elif record.opcode == mcap.STATISTICS:
            _check_statistics(record, seen)
        elif record.opcode == mcap.CHUNK_INDEX:
            indexed.add(_check_chunk_index(record, seen))
        elif record.opcode == mcap.METADATA_INDEX:
            fields = record.fields()
            offset, length = fields.numbers(8, 8)
            _check_target(offset, length, mcap.METADATA, (fields.text(),), seen)
        elif record.opcode == mcap.ATTACHMENT_INDEX:
            fields = record.fields()
            offset, length, *numbers = fields.numbers(8, 8, 8, 8, 8)
            facts: tuple[int | str, ...] = (*numbers, fields.text(), fields.text())
            _check_target(offset, length, mcap.ATTACHMENT, facts, seen)
        elif record.opcode != mcap.SUMMARY_OFFSET and record.opcode < 0x80:
            seen.problem(f"a {mcap.name_of(record.opcode)} record in the summary")
    return indexed


def _check_target(
    offset: int, length: int, opcode: int, facts: tuple[int | str, ...], seen: Seen
) -> None:
    target = seen.offsets.get(offset)
    fits = target is not None and (target.opcode, target.size) == (opcode, length)
    if not fits or seen.described.get(offset) != facts:
        seen.problem(f"an index names a {mcap.name_of(opcode)} record at byte {offset}, wrongly")


def _check_statistics(record: mcap.Record, seen: Seen) -> None:
    fields = record.fields()
    names = "messages schemas channels attachments metadata chunks first-time last-time".split()
    said = dict(zip(names, fields.numbers(8, 2, 4, 4, 4, 4, 8, 8), strict=True))
    per_channel = {channel: count for channel, count in fields.mapping(2, 8) if count}
    counted = {
        "messages": sum(seen.messages.values()),
        "schemas": len(seen.schemas),
        "channels": len(seen.channels),
        "attachments": seen.attachments,
        "metadata": seen.metadata,
        "chunks": len(seen.chunks),
        "first-time": seen.first_ns or 0,
        "last-time": seen.last_ns,
    }
    for name, count in counted.items():
        if said[name] != count:
            seen.problem(f"the statistics say {said[name]} for {name}, the file has {count}")
    if per_channel != dict(seen.messages):
        seen.problem("the statistics count messages per channel differently")


def _check_chunk_index(record: mcap.Record, seen: Seen) -> int:
    fields = record.fields()
    first, last, offset, length = fields.numbers(8, 8, 8, 8)
    places = dict(fields.mapping(2, 8))
    index_length = fields.number(8)
    compression = fields.text()
    packed, unpacked = fields.numbers(8, 8)
    facts = (first, last, length, compression, packed, unpacked)
    if seen.chunks.get(offset) != facts:
        seen.problem(f"the chunk index at byte {record.offset} does not fit its chunk")
        return offset
    behind = seen.chunk_indexes.get(offset, {})
    if {channel: index.offset for channel, index in behind.items()} != places:
        seen.problem(f"the chunk index at byte {record.offset} names wrong message indexes")
    if sum(index.size for index in behind.values()) != index_length:
        seen.problem(f"the chunk index at byte {record.offset} names a wrong length of indexes")
    return offset


def _check_offsets(summary: list[mcap.Record], seen: Seen) -> None:
    """Check that the summary offsets name exactly the groups of records in front of them."""
    content = [record for record in summary if record.opcode != mcap.SUMMARY_OFFSET]
    groups = {}
    for opcode, run in itertools.groupby(content, key=lambda record: record.opcode):
        members = list(run)
        if opcode in groups:
            seen.problem(f"the {mcap.name_of(opcode)} records of the summary are not in one group")
        groups[opcode] = (members[0].offset, members[-1].end - members[0].offset)
    for record in summary:
        if record.opcode != mcap.SUMMARY_OFFSET:
            continue
        opcode, start, length = record.fields().numbers(1, 8, 8)
        if length and groups.get(opcode) != (start, length):
            seen.problem(f"a summary offset names the {mcap.name_of(opcode)} records wrongly")
        if not length and opcode in groups:
            seen.problem(f"a summary offset says there are no {mcap.name_of(opcode)} records")
