# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The records of an MCAP file with their offsets, which the library's readers do not give, and
the comparison of those that describe others with what follows from these.

The library parses the fields of a record, leniently: where a length is wrong it stops short or
reads on. A record counts as parsed only if the library writes the same bytes again.
"""

import itertools
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import fields
from io import BytesIO
from typing import NamedTuple

from mcap import records as mcap
from mcap.data_stream import RecordBuilder
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.stream_reader import StreamReader

PREFIX = struct.Struct("<BQ")  # opcode and length in front of every record
CRC_BYTES = 4
PRIVATE = 0x80  # opcodes from here on are an application's own: their content is not checked
Key = tuple[type[mcap.McapRecord], int]


class Malformed(Exception):
    """Bytes that contradict the specification; the message names place and kind."""


class Record(NamedTuple):
    """One record: kind, offset in its buffer, and content."""

    opcode: int
    offset: int
    content: memoryview

    @property
    def name(self) -> str:
        """Kind of the record as text."""
        if self.opcode not in {each.value for each in Opcode}:
            return f"unknown (opcode {self.opcode})"
        return str(Opcode(self.opcode).name).lower().replace("_", "-")

    @property
    def size(self) -> int:
        """Bytes of the whole record."""
        return PREFIX.size + len(self.content)

    def parsed(self) -> mcap.McapRecord:
        """Return the library's record, or raise Malformed: a text not UTF-8, or a wrong length."""
        raw = PREFIX.pack(self.opcode, len(self.content)) + self.content
        builder = RecordBuilder()
        try:
            found = next(StreamReader(BytesIO(raw), skip_magic=True, emit_chunks=True).records)
            found.write(builder)
        except UnicodeDecodeError as error:
            raise Malformed(f"at byte {self.offset}: a text is not UTF-8") from error
        except (EndOfFile, struct.error) as error:
            raise self.wrong_length() from error
        rewritten = builder.end()[PREFIX.size :]
        if isinstance(
            found, mcap.Attachment
        ):  # the library writes the checksum that it should have
            rewritten = rewritten[:-CRC_BYTES]
        if self.content[: len(rewritten)] != rewritten:  # behind them, fields may have been added
            raise self.wrong_length()
        return found

    def wrong_length(self) -> Malformed:
        """Return the error of a length that its record does not have."""
        return Malformed(
            f"at byte {self.offset}: the {self.name} record contradicts its own lengths"
        )


def records(buffer: memoryview, start: int, end: int) -> Iterator[Record]:
    """Yield records one behind the other; raise :class:`Malformed` where the next does not fit."""
    offset = start
    while offset < end:
        if offset + PREFIX.size > end:
            raise Malformed(f"at byte {offset}: {end - offset} bytes are no record")
        opcode, length = PREFIX.unpack_from(buffer, offset)
        begin = offset + PREFIX.size
        record = Record(opcode, offset, buffer[begin : min(begin + length, end)])
        if begin + length > end:
            what = f"a {record.name} record of {length} bytes, {end - begin} are left"
            raise Malformed(f"at byte {offset}: {what}")
        yield record
        offset = begin + length


def key_of(record: mcap.McapRecord) -> Key:
    """Return the identity of a record among others of its kind."""
    match record:
        case mcap.Schema(id=key) | mcap.Channel(id=key):
            return type(record), key
        case mcap.MetadataIndex(offset=key) | mcap.AttachmentIndex(offset=key):
            return type(record), key
        case mcap.ChunkIndex(chunk_start_offset=key) | mcap.SummaryOffset(group_opcode=key):
            return type(record), key
    return type(record), 0


class Expected:
    """The records that follow from a file's data section, filled while that is checked."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self.notes: list[str] = []
        self.known: dict[Key, mcap.McapRecord] = {}
        self.messages: Counter[int] = Counter()  # by channel
        self.times_ns: tuple[int, int] = (0, 0)

    def statistics(self) -> mcap.Statistics:
        """Return the statistics of what was checked so far."""
        kinds = Counter(kind for kind, _ in self.known)
        return mcap.Statistics(
            message_count=self.messages.total(),
            schema_count=kinds[mcap.Schema],
            channel_count=kinds[mcap.Channel],
            attachment_count=kinds[mcap.AttachmentIndex],
            metadata_count=kinds[mcap.MetadataIndex],
            chunk_count=kinds[mcap.ChunkIndex],
            message_start_time=self.times_ns[0],
            message_end_time=self.times_ns[1],
            channel_message_counts=dict(self.messages),
        )

    def expect(self, record: mcap.McapRecord) -> None:
        """Expect a record, in place of one with its identity."""
        self.known[key_of(record)] = record

    def offsets(self, summary: list[Record]) -> int:
        """Expect an offset of each group of records; return where the offsets begin, or 0."""
        begin = 0
        for opcode, run in itertools.groupby(summary, key=lambda record: record.opcode):
            members = list(run)
            start = members[0].offset
            if opcode == Opcode.SUMMARY_OFFSET:
                begin = begin or start
            elif (mcap.SummaryOffset, opcode) in self.known:
                text = f"the {members[0].name} records of the summary are not in one group"
                self.problems.append(text)
            self.expect(mcap.SummaryOffset(opcode, start, sum(each.size for each in members)))
        return begin

    def checksum(self, what: str, crc: int, data: memoryview) -> None:
        """Check a checksum; one that the writer left out (0) is noted."""
        if not crc:
            self.notes.append(f"no checksum of the {what}")
        elif crc != zlib.crc32(data):
            self.problems.append(f"the checksum of the {what} is wrong")

    def compare(self, record: Record, stored: mcap.McapRecord) -> None:
        """Compare a record with the one that follows from what it describes."""
        what = f"the {record.name} at byte {record.offset}"
        actual = self.known.get(key_of(stored))
        if actual is None:
            self.problems.append(f"{what} names byte {key_of(stored)[1]}: no such record is there")
            return
        for field in fields(stored):
            found, expected = getattr(stored, field.name), getattr(actual, field.name)
            if found != expected:
                text = f"{what} has {field.name} = {found!r:.60}, not {expected!r:.60}"
                self.problems.append(text)
