# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether an MCAP file is whole: every length, checksum, index and count is right.

Checked are: magic at both ends; that records fill the file; checksum, size and content of every
chunk; the checksum of the data section; message indexes against the messages, chunk indexes
against chunks and message indexes; metadata and attachment indexes; repeated schemas and channels;
statistics; summary offsets; the checksum of the summary; the footer. Checksums that a writer left
out (0) are named.
"""

import importlib
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pmwvc_analysis.recording.mcap import mcap_records as mcap
from pmwvc_analysis.recording.mcap.mcap_summary import Seen, check_summary
from pmwvc_core.errors import RecordingError

MOST_PROBLEMS = 50


@dataclass
class Structure:
    """What the check found; a file without problems is whole."""

    problems: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    messages: int = 0
    chunks: int = 0

    @property
    def whole(self) -> bool:
        """Tell whether nothing is wrong."""
        return not self.problems


def check_file(path: str | Path) -> Structure:
    """Check one file.

    Raises
    ------
    RecordingError
        If it cannot be read at all.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise RecordingError(f"cannot read {path}: {error.strerror or error}") from error
    return check_bytes(data)


def check_bytes(data: bytes) -> Structure:
    """Check the bytes of a file."""
    result = Structure()
    seen = Seen()
    try:
        _check(memoryview(data), seen, result)
    except mcap.Malformed as error:
        seen.problem(str(error))
    result.messages = sum(seen.messages.values())
    result.chunks = len(seen.chunks)
    result.notes = seen.notes
    result.problems = seen.problems[:MOST_PROBLEMS]
    if len(seen.problems) > MOST_PROBLEMS:
        result.problems.append(f"and {len(seen.problems) - MOST_PROBLEMS} more")
    return result


def _check(data: memoryview, seen: Seen, result: Structure) -> None:
    magic = len(mcap.MAGIC)
    if bytes(data[:magic]) != mcap.MAGIC:
        raise mcap.Malformed("the file does not begin as an MCAP file does")
    end = len(data)
    if bytes(data[-magic:]) == mcap.MAGIC and len(data) >= 2 * magic:
        end -= magic
    else:
        seen.problem("the file does not end as an MCAP file does: it was not closed")
    data_end = _check_data_section(data, magic, end, seen)
    check_summary(data, data_end, end, seen)


def _check_data_section(data: memoryview, start: int, end: int, seen: Seen) -> int:
    """Check everything up to the data-end record and return the offset behind that."""
    chunk: mcap.Record | None = None
    for place, record in enumerate(mcap.records(data, start, end)):
        if (place == 0) != (record.opcode == mcap.HEADER):
            raise mcap.Malformed(f"at byte {record.offset}: the header has to come first, once")
        seen.offsets[record.offset] = record
        if record.opcode == mcap.MESSAGE_INDEX:
            _check_message_index(record, chunk, seen)
            continue
        _close_chunk(chunk, seen)
        chunk = None
        if record.opcode == mcap.CHUNK:
            chunk = record
            _check_chunk(record, seen)
        elif record.opcode == mcap.DATA_END:
            expected = record.fields().number(4)
            if expected == 0:
                seen.notes.append("no checksum of the data section")
            elif expected != zlib.crc32(data[: record.offset]):
                seen.problem("the checksum of the data section is wrong")
            return record.end
        else:
            _check_plain(record, seen)
    raise mcap.Malformed("there is no data-end record: writing did not come to its end")


def _check_plain(record: mcap.Record, seen: Seen) -> None:
    """Check a record outside of chunks."""
    if record.opcode == mcap.HEADER:
        fields = record.fields()
        fields.text(), fields.text()
    elif record.opcode in (mcap.SCHEMA, mcap.CHANNEL, mcap.MESSAGE):
        _check_content(record, seen)
    elif record.opcode == mcap.METADATA:
        seen.metadata += 1
        fields = record.fields()
        seen.described[record.offset] = (fields.text(),)
        fields.texts()
    elif record.opcode == mcap.ATTACHMENT:
        seen.attachments += 1
        fields = record.fields()
        log_time, create_time = fields.numbers(8, 8)
        name, kind = fields.text(), fields.text()
        size = len(fields.block(8))
        seen.described[record.offset] = (log_time, create_time, size, name, kind)
        crc = int.from_bytes(record.content[-4:], "little")
        if crc and crc != zlib.crc32(record.content[:-4]):
            seen.problem(f"at byte {record.offset}: the checksum of an attachment is wrong")
    elif record.opcode < 0x80:
        raise mcap.Malformed(
            f"at byte {record.offset}: a {mcap.name_of(record.opcode)} record in the data section"
        )


def _check_content(record: mcap.Record, seen: Seen) -> int | None:
    """Check a schema, channel or message; return the log time of a message."""
    fields = record.fields()
    if record.opcode == mcap.SCHEMA:
        number = fields.number(2)
        fields.text(), fields.text(), fields.block(4)
        _same(seen.schemas, number, record, f"schema {number}", seen)
    elif record.opcode == mcap.CHANNEL:
        number, schema = fields.numbers(2, 2)
        fields.text(), fields.text(), fields.texts()
        if schema and schema not in seen.schemas:
            seen.problem(f"channel {number} has a schema, {schema}, that comes nowhere before")
        _same(seen.channels, number, record, f"channel {number}", seen)
    elif record.opcode == mcap.MESSAGE:
        channel, _, log_time, _ = fields.numbers(2, 4, 8, 8)
        if channel not in seen.channels:
            seen.problem(f"a message of channel {channel}, which comes nowhere before")
        seen.message(channel, log_time)
        return log_time
    else:
        raise mcap.Malformed(f"a {mcap.name_of(record.opcode)} record inside a chunk")
    return None


def _same(
    known: dict[int, bytes], number: int, record: mcap.Record, what: str, seen: Seen
) -> None:
    if known.setdefault(number, bytes(record.content)) != bytes(record.content):
        seen.problem(f"at byte {record.offset}: {what} is not what it was before")


def _check_chunk(record: mcap.Record, seen: Seen) -> None:
    """Check a chunk's checksum, sizes, times and the records in it."""
    fields = record.fields()
    first, last, size, crc = fields.numbers(8, 8, 8, 4)
    compression = fields.text()
    packed = fields.block(8)
    seen.chunks[record.offset] = (first, last, record.size, compression, len(packed), size)
    seen.in_chunk = {}
    seen.indexed = {}
    try:
        content = unpack(bytes(packed), compression, size)
    except Exception as error:  # each decompressor has errors of its own
        seen.problem(f"the chunk at byte {record.offset} cannot be unpacked: {error}")
        return
    if len(content) != size:
        seen.problem(f"the chunk at byte {record.offset} has {len(content)} bytes, not {size}")
    if crc and crc != zlib.crc32(content):
        seen.problem(f"the checksum of the chunk at byte {record.offset} is wrong")
        return
    if not crc:
        seen.notes.append(f"no checksum of the chunk at byte {record.offset}")
    times = []
    for inner in mcap.records(content, 0, len(content)):
        if (log_time := _check_content(inner, seen)) is not None:
            times.append(log_time)
            channel = int.from_bytes(inner.content[:2], "little")
            seen.in_chunk.setdefault(channel, set()).add((log_time, inner.offset))
    if times and (min(times), max(times)) != (first, last):
        seen.problem(f"the chunk at byte {record.offset} names times its messages do not have")


def unpack(packed: bytes, compression: str, size: int) -> bytes:
    """Return the content of a chunk."""
    if compression == "":
        return packed
    if compression == "zstd":
        import zstandard

        return zstandard.ZstdDecompressor().decompress(packed, max_output_size=max(size, 1))
    if compression == "lz4":
        frame: Any = importlib.import_module("lz4.frame")
        content: bytes = frame.decompress(packed)
        return content
    raise ValueError(f"unknown compression {compression!r}")


def _check_message_index(record: mcap.Record, chunk: mcap.Record | None, seen: Seen) -> None:
    """Check an index against the messages of the chunk in front of it."""
    if chunk is None:
        raise mcap.Malformed(f"at byte {record.offset}: a message index without a chunk before it")
    fields = record.fields()
    channel = fields.number(2)
    entries = set(fields.mapping(8, 8))
    seen.indexed[channel] = record
    if entries != seen.in_chunk.get(channel, set()):
        seen.problem(f"the message index at byte {record.offset} does not fit its chunk")


def _close_chunk(chunk: mcap.Record | None, seen: Seen) -> None:
    """Check that every channel of a chunk was indexed, once all indexes behind it have passed."""
    if chunk is None:
        return
    seen.chunk_indexes[chunk.offset] = dict(seen.indexed)
    if seen.indexed and set(seen.in_chunk) - set(seen.indexed):
        seen.problem(f"the chunk at byte {chunk.offset} has messages that no index names")
