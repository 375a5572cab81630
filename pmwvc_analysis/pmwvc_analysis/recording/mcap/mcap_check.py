# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The check that an MCAP file is whole: every length, checksum, index and count is right.

Records must fill the file, and every record that describes others (repeated schemas and channels,
indexes, statistics, summary offsets, the footer) must equal the one that follows from what it
describes. Checksums that a writer left out (0) are noted.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from mcap import records as mcap
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC as MAGIC
from zstandard import ZstdError

from pmwvc_analysis.recording.mcap.mcap_records import (
    CRC_BYTES,
    PRIVATE,
    Expected,
    Malformed,
    Record,
    key_of,
    records,
)
from pmwvc_core.errors import file_errors

MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
MESSAGE_INDEX = struct.Struct("<HI")  # channel, bytes of entries
ENTRY = struct.Struct("<QQ")  # log time, offset in the chunk
FOOTER_BYTES, MOST_PROBLEMS = 20, 50
COMPRESSIONS = ("", "lz4", "zstd")
CONTENT = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)


@dataclass(frozen=True)
class Structure:
    """The result of the check; a file without problems is whole."""

    problems: list[str]
    notes: list[str]
    messages: int
    chunks: int

    @property
    def whole(self) -> bool:
        """Tell whether nothing is wrong."""
        return not self.problems


def check_file(path: str | Path) -> Structure:
    """Check one file; RecordingError where it cannot be read at all."""
    with file_errors(f"read {path}"):
        return check_bytes(Path(path).read_bytes())


def check_bytes(data: bytes) -> Structure:
    """Check the bytes of a file."""
    check = _Check(memoryview(data))
    problems, notes = check.problems, check.notes
    try:
        check.run()
    except Malformed as error:
        problems.append(str(error))
    if len(problems) > MOST_PROBLEMS:
        problems[MOST_PROBLEMS:] = [f"and {len(problems) - MOST_PROBLEMS} more"]
    counted = check.statistics()
    return Structure(problems, notes, counted.message_count, counted.chunk_count)


class _Check(Expected):
    """One pass over a file: its data section, from which the summary follows, then the summary."""

    def __init__(self, data: memoryview) -> None:
        super().__init__()
        self._data = data
        self._entries: dict[int, set[tuple[int, int]]] = {}  # of the newest chunk, by channel

    def run(self) -> None:
        """Check the whole file; raises :class:`Malformed` where that cannot go on."""
        start, end = len(MAGIC), len(self._data)
        if self._data[:start] != MAGIC:
            raise Malformed("the file does not begin as an MCAP file does")
        if self._data[-start:] == MAGIC and end >= 2 * start:
            end -= start
        else:
            self.problems.append("the file does not end as an MCAP file does: it was not closed")
        found = records(self._data, start, end)
        chunk: mcap.ChunkIndex | None = None
        for record in found:
            if (record.offset == start) != (record.opcode == Opcode.HEADER):
                raise Malformed(f"at byte {record.offset}: the header has to come first, once")
            if record.opcode == Opcode.MESSAGE_INDEX:
                self._check_message_index(record, chunk)
                continue
            indexed = chunk.message_index_offsets if chunk else {}
            if chunk and indexed and self._entries.keys() - indexed.keys():
                where = f"the chunk at byte {chunk.chunk_start_offset}"
                self.problems.append(f"{where} has messages without an index")
            chunk = None
            if record.opcode == Opcode.DATA_END:
                crc = int.from_bytes(record.content[:CRC_BYTES], "little")
                self.checksum("data section", crc, self._data[: record.offset])
                self._check_summary(record.offset + record.size, found)
                return
            if record.opcode in CONTENT:
                self._check_content(record)
            elif record.opcode < PRIVATE:
                chunk = self._check_other(record)
        raise Malformed("there is no data-end record: the file was not written to its end")

    def _check_content(self, record: Record) -> None:
        """Check a schema, channel or message."""
        if record.opcode != Opcode.MESSAGE:
            found = record.parsed()
            schema = found.schema_id if isinstance(found, mcap.Channel) else 0
            if schema and (mcap.Schema, schema) not in self.known:
                text = f"a {record.name} of schema {schema}, defined nowhere before"
                self.problems.append(text)
            self.known.setdefault(key_of(found), found)
            self.compare(record, found)
            return
        if len(record.content) < MESSAGE.size:
            raise record.wrong_length()
        channel, _, log_ns, _ = MESSAGE.unpack_from(record.content)
        if (mcap.Channel, channel) not in self.known:
            self.problems.append(f"a message of channel {channel}, defined nowhere before")
        first_ns, last_ns = self.times_ns if self.messages else (log_ns, log_ns)
        self.times_ns = min(first_ns, log_ns), max(last_ns, log_ns)
        self.messages[channel] += 1
        self._entries.setdefault(channel, set()).add((log_ns, record.offset))

    def _check_other(self, record: Record) -> mcap.ChunkIndex | None:
        """Check any other record of the data section; return the index of a chunk."""
        match record.parsed():
            case mcap.Chunk() as chunk:
                return self._check_chunk(record, chunk)
            case mcap.Metadata(name=name):
                self.expect(mcap.MetadataIndex(record.offset, record.size, name))
            case mcap.Attachment(log_time=logged, create_time=created, data=data) as found:
                where, texts = (record.offset, record.size), (found.name, found.media_type)
                self.expect(mcap.AttachmentIndex(*where, logged, created, len(data), *texts))
                if crc := int.from_bytes(record.content[-CRC_BYTES:], "little"):
                    content = record.content[:-CRC_BYTES]
                    self.checksum(f"attachment at byte {record.offset}", crc, content)
            case mcap.Header():
                pass
            case _:
                what = f"a {record.name} record in the data section"
                raise Malformed(f"at byte {record.offset}: {what}")
        return None

    def _check_chunk(self, record: Record, chunk: mcap.Chunk) -> mcap.ChunkIndex:
        """Check a chunk; return its index, still without the message indexes behind it."""
        index = mcap.ChunkIndex(
            chunk_start_offset=record.offset,
            chunk_length=record.size,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            uncompressed_size=chunk.uncompressed_size,
            message_start_time=chunk.message_start_time,
            message_end_time=chunk.message_end_time,
            message_index_offsets={},
            message_index_length=0,
        )
        self.expect(index)
        self._entries = {}
        what = f"the chunk at byte {record.offset}"
        try:
            if chunk.compression not in COMPRESSIONS:  # the library would take it for none
                raise ValueError(f"unknown compression {chunk.compression!r}")
            stream, size = get_chunk_data_stream(chunk, validate_crc=True)
        except CRCValidationError:
            self.problems.append(f"the checksum of {what} is wrong")
            return index
        except (McapError, ZstdError, ValueError, RuntimeError) as error:
            self.problems.append(f"{what} cannot be unpacked: {error}")
            return index
        if not chunk.uncompressed_crc:
            self.notes.append(f"no checksum of {what}")
        if size != chunk.uncompressed_size:
            self.problems.append(f"{what} has {size} bytes, not {chunk.uncompressed_size}")
        for inner in records(memoryview(stream.read(size)), 0, size):
            if inner.opcode not in CONTENT:
                raise Malformed(f"a {inner.name} record inside a chunk")
            self._check_content(inner)
        span = chunk.message_start_time, chunk.message_end_time
        times = [log_ns for entries in self._entries.values() for log_ns, _ in entries]
        if times and (min(times), max(times)) != span:
            self.problems.append(f"{what} names times that its messages do not have")
        return index

    def _check_message_index(self, record: Record, chunk: mcap.ChunkIndex | None) -> None:
        """Check an index against the messages of the chunk in front of it."""
        where = f"the message index at byte {record.offset}"
        if chunk is None or len(record.content) < MESSAGE_INDEX.size:
            raise Malformed(f"{where} is too short, or no chunk is before it")
        channel, size = MESSAGE_INDEX.unpack_from(record.content)
        raw = record.content[MESSAGE_INDEX.size : MESSAGE_INDEX.size + size]
        chunk.message_index_offsets[channel] = record.offset
        chunk.message_index_length += record.size
        whole = len(raw) == size and size % ENTRY.size == 0
        if not whole or set(ENTRY.iter_unpack(raw)) != self._entries.get(channel, set()):
            self.problems.append(f"{where} does not fit its chunk")

    def _check_summary(self, start: int, found: Iterator[Record]) -> None:
        """Check the records behind the data section, which ends at ``start``."""
        summary = list(found)
        if not summary or (last := summary.pop()).opcode != Opcode.FOOTER:
            raise Malformed("the file does not end with a footer")
        if len(last.content) != FOOTER_BYTES:
            self.problems.append("the footer has another size than it should")
        footer = last.parsed()
        assert isinstance(footer, mcap.Footer)
        end = last.offset + last.size - CRC_BYTES
        self.checksum("summary", footer.summary_crc, self._data[start:end])
        offsets_start = self.offsets(summary)
        indexed = set()
        # by opcode: schemas and channels before the statistics that count them
        for record in sorted(summary, key=lambda record: record.opcode):
            if record.opcode >= PRIVATE:
                continue
            match stored := record.parsed():
                case mcap.Schema() | mcap.Channel():  # one without messages may stand only here
                    self._check_content(record)
                    continue
                case mcap.Statistics(channel_message_counts=counts):
                    self.expect(self.statistics())
                    counts = {channel: count for channel, count in counts.items() if count}
                    stored = replace(stored, channel_message_counts=counts)
                case mcap.SummaryOffset():
                    self.known.setdefault(key_of(stored), replace(stored, group_length=0))
                case mcap.ChunkIndex():
                    indexed.add(key_of(stored))
                case mcap.MetadataIndex() | mcap.AttachmentIndex():
                    pass
                case _:
                    self.problems.append(f"a {record.name} record in the summary")
                    continue
            self.compare(record, stored)
        chunks = {key for key in self.known if key[0] is mcap.ChunkIndex}
        if indexed and chunks - indexed:
            self.problems.append(f"{len(chunks - indexed)} chunks have no index in the summary")
        self.expect(mcap.Footer(start if summary else 0, offsets_start, footer.summary_crc))
        self.compare(last, footer)
