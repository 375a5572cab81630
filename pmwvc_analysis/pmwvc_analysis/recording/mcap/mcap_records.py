# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The records of an MCAP file with their offsets, which the library's readers do not give, and
those that describe others (schemas and channels that come again, indexes, statistics, summary
offsets, footer), compared with what follows from these.

The library parses the fields of a record, leniently: where a length is wrong it stops short or
reads on. A record counts as parsed only if the library writes the same bytes again.
"""

import itertools
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import fields, replace
from io import BytesIO
from typing import NamedTuple

from mcap import records as mcap
from mcap.data_stream import RecordBuilder
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Attachment, McapRecord
from mcap.stream_reader import StreamReader

PREFIX = struct.Struct("<BQ")  # opcode and length in front of every record
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
MESSAGE_INDEX = struct.Struct("<HI")  # channel, bytes of entries
ENTRY = struct.Struct("<QQ")  # log time, offset in the chunk
CRC_BYTES = 4
FOOTER_BYTES = 20
PRIVATE = 0x80  # opcodes from here on are an application's own


class Malformed(Exception):
    """Bytes that contradict the specification; the message names place and kind."""


def name_of(opcode: int) -> str:
    """Return the kind of a record as text."""
    try:
        name: str = Opcode(opcode).name
    except ValueError:
        return f"unknown (opcode {opcode})"
    return name.lower().replace("_", "-")


class Record(NamedTuple):
    """One record: kind, offset in its buffer, and content."""

    opcode: int
    offset: int
    content: memoryview

    @property
    def name(self) -> str:
        """Kind of the record as text."""
        return name_of(self.opcode)

    @property
    def private(self) -> bool:
        """True for a record of an application's own: its content is not checked."""
        return self.opcode >= PRIVATE

    @property
    def size(self) -> int:
        """Bytes of the whole record."""
        return PREFIX.size + len(self.content)

    @property
    def end(self) -> int:
        """Offset behind the record."""
        return self.offset + self.size

    def parsed(self) -> McapRecord:
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
        if isinstance(found, Attachment):  # the library writes the checksum that it should have
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
        if begin + length > end:
            raise Malformed(
                f"at byte {offset}: a {name_of(opcode)} record of {length} bytes, "
                f"{end - begin} are left"
            )
        yield Record(opcode, offset, buffer[begin : begin + length])
        offset = begin + length


class Summary:
    """The expected summary of a file, filled while its data section is checked."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self.notes: list[str] = []
        self._messages: Counter[int] = Counter()  # by channel
        self._times_ns: tuple[int, int] | None = None
        self._expected: dict[tuple[type[mcap.McapRecord], int], mcap.McapRecord] = {}

    def expect(self, record: mcap.McapRecord) -> None:
        """Expect an index record."""
        self._expected[_key(record)] = record

    def message(self, channel: int, log_ns: int) -> None:
        """Count a message."""
        if (mcap.Channel, channel) not in self._expected:
            self.problems.append(f"a message of channel {channel}, defined nowhere before")
        self._messages[channel] += 1
        first_ns, last_ns = self._times_ns or (log_ns, log_ns)
        self._times_ns = min(first_ns, log_ns), max(last_ns, log_ns)

    def definition(self, record: Record) -> None:
        """Check a schema or channel."""
        found = record.parsed()
        schema = found.schema_id if isinstance(found, mcap.Channel) else 0
        if schema and (mcap.Schema, schema) not in self._expected:
            self.problems.append(f"a {record.name} of schema {schema}, defined nowhere before")
        self._expected.setdefault(_key(found), found)
        self._compare(record, found)

    def checksum(self, what: str, crc: int, data: memoryview) -> None:
        """Check a checksum; one that the writer left out (0) is noted."""
        if not crc:
            self.notes.append(f"no checksum of the {what}")
        elif crc != zlib.crc32(data):
            self.problems.append(f"the checksum of the {what} is wrong")

    def statistics(self) -> mcap.Statistics:
        """Return the statistics of what was checked so far."""
        kinds = Counter(kind for kind, _ in self._expected)
        first_ns, last_ns = self._times_ns or (0, 0)
        return mcap.Statistics(
            message_count=self._messages.total(),
            schema_count=kinds[mcap.Schema],
            channel_count=kinds[mcap.Channel],
            attachment_count=kinds[mcap.AttachmentIndex],
            metadata_count=kinds[mcap.MetadataIndex],
            chunk_count=kinds[mcap.ChunkIndex],
            message_start_time=first_ns,
            message_end_time=last_ns,
            channel_message_counts=dict(self._messages),
        )

    def check(self, data: memoryview, start: int, found: list[Record]) -> None:
        """Check the records behind the data section of ``data``, which ends at ``start``."""
        if not found or found[-1].opcode != Opcode.FOOTER:
            raise Malformed("the file does not end with a footer")
        *summary, last = found
        if len(last.content) != FOOTER_BYTES:
            self.problems.append("the footer has another size than it should")
        footer = last.parsed()
        assert isinstance(footer, mcap.Footer)
        self.checksum("summary", footer.summary_crc, data[start : last.end - CRC_BYTES])
        offsets_start = self._expect_offsets(summary)
        indexed = set()
        # by opcode: schemas and channels before the statistics that count them
        for record in sorted(summary, key=lambda record: record.opcode):
            if record.private:
                continue
            match stored := record.parsed():
                case mcap.Schema() | mcap.Channel():  # one without messages may stand only here
                    self.definition(record)
                    continue
                case mcap.Statistics(channel_message_counts=counts):
                    self.expect(self.statistics())
                    counts = {channel: count for channel, count in counts.items() if count}
                    stored = replace(stored, channel_message_counts=counts)
                case mcap.SummaryOffset():
                    self._expected.setdefault(_key(stored), replace(stored, group_length=0))
                case mcap.ChunkIndex():
                    indexed.add(_key(stored))
                case mcap.MetadataIndex() | mcap.AttachmentIndex():
                    pass
                case _:
                    self.problems.append(f"a {record.name} record in the summary")
                    continue
            self._compare(record, stored)
        chunks = {key for key in self._expected if key[0] is mcap.ChunkIndex}
        if indexed and chunks - indexed:
            self.problems.append(f"{len(chunks - indexed)} chunks have no index in the summary")
        self.expect(mcap.Footer(start if summary else 0, offsets_start, footer.summary_crc))
        self._compare(last, footer)

    def _expect_offsets(self, summary: list[Record]) -> int:
        """Expect an offset of each group of records; return where the offsets begin, or 0."""
        begin = 0
        for opcode, run in itertools.groupby(summary, key=lambda record: record.opcode):
            members = list(run)
            start, end = members[0].offset, members[-1].end
            if opcode == Opcode.SUMMARY_OFFSET:
                begin = begin or start
            elif (mcap.SummaryOffset, opcode) in self._expected:
                text = f"the {members[0].name} records of the summary are not in one group"
                self.problems.append(text)
            self.expect(mcap.SummaryOffset(opcode, start, end - start))
        return begin

    def _compare(self, record: Record, stored: mcap.McapRecord) -> None:
        """Compare a record with the one that follows from what it describes."""
        what = f"the {record.name} at byte {record.offset}"
        actual = self._expected.get(_key(stored))
        if actual is None:
            self.problems.append(f"{what} names byte {_key(stored)[1]}: no such record is there")
            return
        for field in fields(stored):
            found, expected = getattr(stored, field.name), getattr(actual, field.name)
            if found != expected:
                text = f"{what} has {field.name} = {found!r:.60}, not {expected!r:.60}"
                self.problems.append(text)


def _key(record: mcap.McapRecord) -> tuple[type[mcap.McapRecord], int]:
    """Return the identity of a record among others of its kind."""
    match record:
        case mcap.Schema(id=key) | mcap.Channel(id=key):
            return type(record), key
        case mcap.MetadataIndex(offset=key) | mcap.AttachmentIndex(offset=key):
            return type(record), key
        case mcap.ChunkIndex(chunk_start_offset=key) | mcap.SummaryOffset(group_opcode=key):
            return type(record), key
    return type(record), 0
