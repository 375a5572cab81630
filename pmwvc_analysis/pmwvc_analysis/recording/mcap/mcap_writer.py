# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The bytes of an MCAP file: chunks with their indexes, and the summary that completes it.

The library writes every record but the many: a message and its index entry are packed here in a
few microseconds, and all that grows with time is the index, one packed record a chunk.
"""

import struct
import zlib
from collections import Counter
from collections.abc import Mapping
from typing import BinaryIO

from mcap import records as mcap
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC as MAGIC

from pmwvc_analysis.recording.mcap.mcap_records import ENTRY, MESSAGE, MESSAGE_INDEX, PREFIX

COMPRESSION = "zstd"
LEVEL = 1  # half the time of the default for files a twentieth larger
_MESSAGE = struct.Struct(PREFIX.format + MESSAGE.format[1:])
_OPCODE = int(Opcode.MESSAGE)  # looking up a member of an enumeration takes its time


def _bytes(record: mcap.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    content: bytes = builder.end()
    return content


class McapWriter:
    """Writes one MCAP file to a binary stream, which is not closed here."""

    def __init__(self, stream: BinaryIO) -> None:
        import zstandard

        self._stream = stream
        self._compressor = zstandard.ZstdCompressor(level=LEVEL)
        self._offset = 0
        self._crc = 0
        self._schemas: list[bytes] = []
        self._channels: list[bytes] = []
        self._chunk = bytearray()
        self._index: dict[int, bytearray] = {}  # channel -> (log time, offset) of this chunk
        self._chunk_times: tuple[int, int] | None = None
        self._times: tuple[int, int] | None = None
        self._counts: Counter[int] = Counter()
        self._chunks = 0
        self._chunk_indexes = bytearray()
        self._metadata_indexes: list[bytes] = []

    def start(self, *, profile: str, library: str) -> None:
        """Write magic and header."""
        self._put(MAGIC + _bytes(mcap.Header(profile, library)))

    def register_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema to the current chunk and return its number."""
        number = len(self._schemas) + 1
        self._schemas.append(_bytes(mcap.Schema(number, data, encoding, name)))
        self._chunk += self._schemas[-1]
        return number

    def register_channel(
        self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]
    ) -> int:
        """Add a channel to the current chunk and return its number."""
        number = len(self._channels) + 1
        channel = mcap.Channel(number, topic, encoding, dict(metadata), schema)
        self._channels.append(_bytes(channel))
        self._chunk += self._channels[-1]
        return number

    def add_message(
        self, channel: int, log_ns: int, data: bytes, publish_ns: int, sequence: int
    ) -> None:
        """Add a message to the current chunk."""
        entries = self._index.get(channel)
        if entries is None:
            entries = self._index[channel] = bytearray()
        entries += ENTRY.pack(log_ns, len(self._chunk))
        size = MESSAGE.size + len(data)
        self._chunk += _MESSAGE.pack(_OPCODE, size, channel, sequence, log_ns, publish_ns)
        self._chunk += data
        first, last = self._chunk_times or (log_ns, log_ns)
        self._chunk_times = (min(first, log_ns), max(last, log_ns))

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a metadata record; the current chunk ends."""
        self.flush()
        record = _bytes(mcap.Metadata(name, dict(values)))
        self._metadata_indexes.append(_bytes(mcap.MetadataIndex(self._offset, len(record), name)))
        self._put(record)

    def flush(self) -> None:
        """End the current chunk and hand it to the system."""
        if self._chunk:
            self._end_chunk()
        self._stream.flush()

    def _end_chunk(self) -> None:
        first, last = self._chunk_times or (0, 0)
        size = len(self._chunk)
        packed = self._compressor.compress(bytes(self._chunk))
        crc = zlib.crc32(self._chunk)
        chunk = _bytes(mcap.Chunk(COMPRESSION, packed, last, first, crc, size))
        offsets, indexes = {}, bytearray()
        for channel, entries in self._index.items():
            offsets[channel] = self._offset + len(chunk) + len(indexes)
            indexes += PREFIX.pack(Opcode.MESSAGE_INDEX, MESSAGE_INDEX.size + len(entries))
            indexes += MESSAGE_INDEX.pack(channel, len(entries)) + entries
            self._counts[channel] += len(entries) // ENTRY.size
        index = mcap.ChunkIndex(
            chunk_start_offset=self._offset,
            chunk_length=len(chunk),
            compression=COMPRESSION,
            compressed_size=len(packed),
            uncompressed_size=size,
            message_start_time=first,
            message_end_time=last,
            message_index_offsets=offsets,
            message_index_length=len(indexes),
        )
        self._put(chunk + indexes)
        self._chunk_indexes += _bytes(index)
        self._chunks += 1
        if self._index:
            begin, end = self._times or (first, last)
            self._times = (min(begin, first), max(end, last))
        self._chunk, self._index, self._chunk_times = bytearray(), {}, None

    def finish(self) -> None:
        """Write data end, summary and footer."""
        self.flush()
        self._put(_bytes(mcap.DataEnd(self._crc)))
        start = self._offset
        summary, offsets = bytearray(), bytearray()
        for opcode, group in (
            (Opcode.SCHEMA, b"".join(self._schemas)),
            (Opcode.CHANNEL, b"".join(self._channels)),
            (Opcode.STATISTICS, _bytes(self._statistics())),
            (Opcode.CHUNK_INDEX, bytes(self._chunk_indexes)),
            (Opcode.METADATA_INDEX, b"".join(self._metadata_indexes)),
        ):
            if group:
                offsets += _bytes(mcap.SummaryOffset(opcode, start + len(summary), len(group)))
                summary += group
        footer = mcap.Footer(start, start + len(summary), 0)
        summary += offsets + _bytes(footer)[:-4]  # the checksum is that of all before it
        self._put(summary + struct.pack("<I", zlib.crc32(summary)) + MAGIC)

    def _statistics(self) -> mcap.Statistics:
        first, last = self._times or (0, 0)
        return mcap.Statistics(
            message_count=self._counts.total(),
            schema_count=len(self._schemas),
            channel_count=len(self._channels),
            attachment_count=0,
            metadata_count=len(self._metadata_indexes),
            chunk_count=self._chunks,
            message_start_time=first,
            message_end_time=last,
            channel_message_counts=dict(sorted(self._counts.items())),
        )

    def _put(self, data: bytes | bytearray) -> None:
        self._stream.write(data)
        self._crc = zlib.crc32(data, self._crc)
        self._offset += len(data)
