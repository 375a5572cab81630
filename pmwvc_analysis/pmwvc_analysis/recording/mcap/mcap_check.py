# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The check that an MCAP file is whole: every length, checksum, index and count is right.

The library's readers verify the checksums of chunks and of the data section. Besides, records must
fill the file, and every record that describes others (repeated schemas and channels, indexes,
statistics, summary offsets, the footer) must equal the one that follows from what it describes.
Checksums that a writer left out (0) are noted.
"""

from dataclasses import dataclass
from pathlib import Path

from mcap import records as mcap
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC as MAGIC
from zstandard import ZstdError

from pmwvc_analysis.recording.mcap.mcap_records import (
    CRC_BYTES,
    ENTRY,
    MESSAGE,
    MESSAGE_INDEX,
    Malformed,
    Record,
    Summary,
    records,
)
from pmwvc_core.errors import file_errors

MOST_PROBLEMS = 50
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
        data = Path(path).read_bytes()
    return check_bytes(data)


def check_bytes(data: bytes) -> Structure:
    """Check the bytes of a file."""
    summary = Summary()
    problems = summary.problems
    try:
        _Check(memoryview(data), summary).run()
    except Malformed as error:
        problems.append(str(error))
    if len(problems) > MOST_PROBLEMS:
        problems[MOST_PROBLEMS:] = [f"and {len(problems) - MOST_PROBLEMS} more"]
    counted = summary.statistics()
    return Structure(problems, summary.notes, counted.message_count, counted.chunk_count)


class _Check:
    """One pass over a file: its data section, then its summary."""

    def __init__(self, data: memoryview, summary: Summary) -> None:
        self._data = data
        self._summary = summary
        self._problems = summary.problems
        self._entries: dict[int, set[tuple[int, int]]] = {}  # of the newest chunk, by channel

    def run(self) -> None:
        """Check the whole file; raises :class:`Malformed` where that cannot go on."""
        start, end = len(MAGIC), len(self._data)
        if self._data[:start] != MAGIC:
            raise Malformed("the file does not begin as an MCAP file does")
        if self._data[-start:] == MAGIC and end >= 2 * start:
            end -= start
        else:
            self._problems.append("the file does not end as an MCAP file does: it was not closed")
        found = records(self._data, start, end)
        chunk: mcap.ChunkIndex | None = None
        for record in found:
            if (record.offset == start) != (record.opcode == Opcode.HEADER):
                raise Malformed(f"at byte {record.offset}: the header has to come first, once")
            if record.opcode == Opcode.MESSAGE_INDEX:
                self._check_message_index(record, chunk)
                continue
            self._check_all_indexed(chunk)
            chunk = None
            if record.opcode == Opcode.DATA_END:
                crc = int.from_bytes(record.content[:CRC_BYTES], "little")
                self._summary.checksum("data section", crc, self._data[: record.offset])
                self._summary.check(self._data, record.end, list(found))
                return
            if record.opcode in CONTENT:
                self._check_content(record)
            elif not record.private:
                chunk = self._check_other(record)
        raise Malformed("there is no data-end record: the file was not written to its end")

    def _check_content(self, record: Record) -> tuple[int, int] | None:
        """Check a schema, channel or message; return channel and log time [ns] of a message."""
        if record.opcode != Opcode.MESSAGE:
            self._summary.definition(record)
            return None
        if len(record.content) < MESSAGE.size:
            raise record.wrong_length()
        channel, _, log_ns, _ = MESSAGE.unpack_from(record.content)
        self._summary.message(channel, log_ns)
        return channel, log_ns

    def _check_other(self, record: Record) -> mcap.ChunkIndex | None:
        """Check any other record of the data section; return the index of a chunk."""
        match record.parsed():
            case mcap.Chunk() as chunk:
                return self._check_chunk(record, chunk)
            case mcap.Metadata(name=name):
                self._summary.expect(mcap.MetadataIndex(record.offset, record.size, name))
            case mcap.Attachment(log_time=logged, create_time=created, data=data) as found:
                where, texts = (record.offset, record.size), (found.name, found.media_type)
                self._summary.expect(
                    mcap.AttachmentIndex(*where, logged, created, len(data), *texts)
                )
                if crc := int.from_bytes(record.content[-CRC_BYTES:], "little"):
                    content = record.content[:-CRC_BYTES]
                    self._summary.checksum(f"attachment at byte {record.offset}", crc, content)
            case mcap.Header():
                pass
            case _:
                raise Malformed(
                    f"at byte {record.offset}: a {record.name} record in the data section"
                )
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
        self._summary.expect(index)
        self._entries = {}
        where = f"the chunk at byte {record.offset}"
        try:
            if chunk.compression not in COMPRESSIONS:  # the library would take it for none
                raise ValueError(f"unknown compression {chunk.compression!r}")
            stream, size = get_chunk_data_stream(chunk, validate_crc=True)
        except CRCValidationError:
            self._problems.append(f"the checksum of {where} is wrong")
            return index
        except (McapError, ZstdError, ValueError, RuntimeError) as error:
            self._problems.append(f"{where} cannot be unpacked: {error}")
            return index
        if not chunk.uncompressed_crc:
            self._summary.notes.append(f"no checksum of {where}")
        if size != chunk.uncompressed_size:
            self._problems.append(f"{where} has {size} bytes, not {chunk.uncompressed_size}")
        for inner in records(memoryview(stream.read(size)), 0, size):
            if inner.opcode not in CONTENT:
                raise Malformed(f"a {inner.name} record inside a chunk")
            if message := self._check_content(inner):
                self._entries.setdefault(message[0], set()).add((message[1], inner.offset))
        times = [log_ns for entries in self._entries.values() for log_ns, _ in entries]
        span = (chunk.message_start_time, chunk.message_end_time)
        if times and (min(times), max(times)) != span:
            self._problems.append(f"{where} names times that its messages do not have")
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
            self._problems.append(f"{where} does not fit its chunk")

    def _check_all_indexed(self, chunk: mcap.ChunkIndex | None) -> None:
        """Check that every channel of a chunk was indexed, once its indexes have passed."""
        indexed = chunk.message_index_offsets if chunk else {}
        if chunk and indexed and self._entries.keys() - indexed.keys():
            where = f"the chunk at byte {chunk.chunk_start_offset}"
            self._problems.append(f"{where} has messages without an index")
