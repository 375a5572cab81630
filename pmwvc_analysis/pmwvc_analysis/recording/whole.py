# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The check that an MCAP file is whole: it reads to its end, its checksums are right, and its
indexes and statistics are those of its content.

The library reads and unpacks the records and checks chunks and data section. Checksums that a
writer left out (0) are noted.
"""

import io
import struct
import zlib
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from pathlib import Path

from mcap import records as mcap
from mcap.opcode import Opcode
from mcap.stream_reader import StreamReader, breakup_chunk

from pmwvc_analysis.recording.salvage import DAMAGE, damage
from pmwvc_core.errors import file_errors

CRC_BYTES, MOST_PROBLEMS = 4, 50
DATA_END = struct.pack("<BQ", Opcode.DATA_END, CRC_BYTES)  # in front of its checksum


@dataclass
class Structure:
    """The result of the check; a file without problems is whole."""

    problems: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    messages: int = 0
    chunks: int = 0

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
    stream, check = io.BytesIO(data), _Check()
    try:
        for record in StreamReader(stream, emit_chunks=True, validate_crcs=True).records:
            check.take(record, stream.tell())
            if isinstance(record, mcap.Footer):
                check.compare(record, data[: stream.tell()])
        if stream.read():
            check.problems.append("bytes follow the end of the file")
    except DAMAGE as error:
        why = damage(error, stream)
        check.problems.append(f"{why}: the file is damaged, or it was not closed")
    if len(check.problems) > MOST_PROBLEMS:
        check.problems[MOST_PROBLEMS:] = [f"and {len(check.problems) - MOST_PROBLEMS} more"]
    return check


class _Check(Structure):
    """What one pass over a file finds: its content, and what the summary behind tells of it."""

    def __init__(self) -> None:
        super().__init__()
        self.data_end = 0
        self._statistics: mcap.Statistics | None = None
        self._definitions: dict[tuple[type, int], mcap.McapRecord] = {}
        self._counts: Counter[int] = Counter()  # messages by channel
        self._times_ns: dict[int, list[int]] = defaultdict(list)  # of a chunk, by channel
        self._span_ns = (0, 0)
        self._places: dict[type, set[tuple[object, ...]]] = defaultdict(set)  # where, and what

    def take(self, record: mcap.McapRecord, end: int) -> None:
        """Take the next record, which ends at a byte of the file."""
        match record:
            case mcap.Chunk():
                self._take_chunk(record, end)
            case mcap.Schema() | mcap.Channel() | mcap.Message():
                self._take_content(record)
            case mcap.MessageIndex(channel_id=channel, records=entries):
                times_ns = sorted(time_ns for time_ns, _ in entries)
                if times_ns != sorted(self._times_ns[channel]):
                    what = f"the message index that ends at byte {end}"
                    self.problems.append(f"{what} is of another chunk")
            case mcap.Metadata(name=name) | mcap.Attachment(name=name):
                self._places[type(record)].add((end, name))
            case mcap.DataEnd(data_section_crc=crc):
                self.data_end = end
                self.notes += [] if crc else ["no checksum of the data section"]
            case mcap.Statistics():
                self._statistics = record
            case mcap.ChunkIndex():
                place = record.chunk_start_offset + record.chunk_length
                span_ns = record.message_start_time, record.message_end_time
                self._places[mcap.ChunkIndex].add((place, *span_ns))
            case mcap.MetadataIndex() | mcap.AttachmentIndex():
                place = record.offset + record.length
                self._places[type(record)].add((place, record.name))

    def _take_chunk(self, chunk: mcap.Chunk, end: int) -> None:
        self.chunks += 1
        span_ns = chunk.message_start_time, chunk.message_end_time
        self._places[mcap.Chunk].add((end, *span_ns))
        self.notes += [] if chunk.uncompressed_crc else [f"no checksum of chunk {self.chunks}"]
        self._times_ns.clear()
        for record in breakup_chunk(chunk, validate_crc=True):
            self._take_content(record)
        times_ns = [each for times in self._times_ns.values() for each in times]
        if times_ns and (min(times_ns), max(times_ns)) != span_ns:
            self.problems.append(f"chunk {self.chunks} names times that its messages do not have")

    def _take_content(self, record: mcap.Schema | mcap.Channel | mcap.Message) -> None:
        if not isinstance(record, mcap.Message):
            if self._definitions.setdefault((type(record), record.id), record) != record:
                what = f"{type(record).__name__.lower()} {record.id}"
                self.problems.append(f"{what} is defined twice, and differently")
            return
        channel, log_ns = record.channel_id, record.log_time
        if (mcap.Channel, channel) not in self._definitions:
            self.problems.append(f"a message of channel {channel}, defined nowhere before")
        first_ns, last_ns = self._span_ns if self.messages else (log_ns, log_ns)
        self._span_ns = min(first_ns, log_ns), max(last_ns, log_ns)
        self.messages += 1
        self._counts[channel] += 1
        self._times_ns[channel].append(log_ns)

    def compare(self, footer: mcap.Footer, data: bytes) -> None:
        """Compare the summary with the content, where ``data`` ends with the footer."""
        if not data[: self.data_end - CRC_BYTES].endswith(DATA_END):
            self.problems.append("there is no end of the data: the file was not finished")
        summary = data[footer.summary_start or self.data_end : -CRC_BYTES]
        if not footer.summary_crc:
            self.notes.append("no checksum of the summary")
        elif footer.summary_crc != zlib.crc32(summary):
            self.problems.append("the checksum of the summary is wrong")
        for kind, index in (
            (mcap.Chunk, mcap.ChunkIndex),
            (mcap.Metadata, mcap.MetadataIndex),
            (mcap.Attachment, mcap.AttachmentIndex),
        ):
            if self._places[index] and self._places[index] != self._places[kind]:
                name = kind.__name__.lower()
                self.problems.append(f"the {name} index does not fit what is in the file")
        if (told := self._statistics) is None:
            return
        kinds = Counter(kind for kind, _ in self._definitions)
        for name, number, counted in (
            ("messages", told.message_count, self.messages),
            ("messages by channel", Counter(told.channel_message_counts), self._counts),
            ("schemas", told.schema_count, kinds[mcap.Schema]),
            ("channels", told.channel_count, kinds[mcap.Channel]),
            ("chunks", told.chunk_count, self.chunks),
            ("times", (told.message_start_time, told.message_end_time), self._span_ns),
        ):
            if number != counted:
                self.problems.append(f"the statistics name {name} {number}, not {counted}")
