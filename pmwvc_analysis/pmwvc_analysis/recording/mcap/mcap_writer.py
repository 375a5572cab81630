# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The bytes of an MCAP file: chunks with their indexes, and the summary that completes it.

Made for hours: a message costs a few microseconds, and all that grows with time is the index, one
packed record a chunk.
"""

import struct
import zlib
from collections import Counter
from collections.abc import Mapping
from typing import BinaryIO

from pmwvc_analysis.recording.mcap import mcap_records as mcap

COMPRESSION = "zstd"
LEVEL = 1  # half the time of the default for files a twentieth larger
_PREFIX = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_FIELDS = _MESSAGE.size - _PREFIX.size
_ENTRY = struct.Struct("<QQ")


def _text(value: str) -> bytes:
    raw = value.encode()
    return struct.pack("<I", len(raw)) + raw


def _texts(values: Mapping[str, str]) -> bytes:
    raw = b"".join(_text(name) + _text(value) for name, value in values.items())
    return struct.pack("<I", len(raw)) + raw


def _record(opcode: int, content: bytes) -> bytes:
    return _PREFIX.pack(opcode, len(content)) + content


class McapWriter:
    """Writes one MCAP file to a binary stream.

    Parameters
    ----------
    stream
        Open for writing; not closed here.
    """

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
        self._metadata = 0
        self._metadata_indexes = bytearray()

    def start(self, *, profile: str, library: str) -> None:
        """Write magic and header."""
        self._put(mcap.MAGIC + _record(mcap.HEADER, _text(profile) + _text(library)))

    def register_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema to the current chunk and return its number."""
        number = len(self._schemas) + 1
        content = struct.pack("<H", number) + _text(name) + _text(encoding)
        self._schemas.append(_record(mcap.SCHEMA, content + struct.pack("<I", len(data)) + data))
        self._chunk += self._schemas[-1]
        return number

    def register_channel(
        self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]
    ) -> int:
        """Add a channel to the current chunk and return its number."""
        number = len(self._channels) + 1
        content = struct.pack("<HH", number, schema) + _text(topic) + _text(encoding)
        self._channels.append(_record(mcap.CHANNEL, content + _texts(metadata)))
        self._chunk += self._channels[-1]
        return number

    def add_message(
        self, channel: int, log_ns: int, data: bytes, publish_ns: int, sequence: int
    ) -> None:
        """Add a message to the current chunk."""
        entries = self._index.get(channel)
        if entries is None:
            entries = self._index[channel] = bytearray()
        entries += _ENTRY.pack(log_ns, len(self._chunk))
        size = _MESSAGE_FIELDS + len(data)
        self._chunk += _MESSAGE.pack(mcap.MESSAGE, size, channel, sequence, log_ns, publish_ns)
        self._chunk += data
        first, last = self._chunk_times or (log_ns, log_ns)
        self._chunk_times = (min(first, log_ns), max(last, log_ns))

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a metadata record; the current chunk ends."""
        self.flush()
        record = _record(mcap.METADATA, _text(name) + _texts(values))
        index = struct.pack("<QQ", self._offset, len(record)) + _text(name)
        self._put(record)
        self._metadata += 1
        self._metadata_indexes += _record(mcap.METADATA_INDEX, index)

    def flush(self) -> None:
        """End the current chunk and hand it to the system."""
        if self._chunk:
            self._end_chunk()
        self._stream.flush()

    def _end_chunk(self) -> None:
        first, last = self._chunk_times or (0, 0)
        packed = self._compressor.compress(bytes(self._chunk))
        sizes = struct.pack("<QQ", len(packed), len(self._chunk))
        head = struct.pack("<QQQI", first, last, len(self._chunk), zlib.crc32(self._chunk))
        content = head + _text(COMPRESSION) + struct.pack("<Q", len(packed)) + packed
        start, chunk = self._offset, _record(mcap.CHUNK, content)
        places, indexes = bytearray(), bytearray()
        for channel, entries in self._index.items():
            places += struct.pack("<HQ", channel, start + len(chunk) + len(indexes))
            content = struct.pack("<HI", channel, len(entries)) + entries
            indexes += _record(mcap.MESSAGE_INDEX, content)
        self._put(chunk + indexes)
        index = struct.pack("<QQQQI", first, last, start, len(chunk), len(places)) + places
        index += struct.pack("<Q", len(indexes)) + _text(COMPRESSION) + sizes
        self._chunk_indexes += _record(mcap.CHUNK_INDEX, index)
        self._chunks += 1
        self._counts.update({c: len(entries) // _ENTRY.size for c, entries in self._index.items()})
        if self._index:
            begin, end = self._times or (first, last)
            self._times = (min(begin, first), max(end, last))
        self._chunk, self._index, self._chunk_times = bytearray(), {}, None

    def finish(self) -> None:
        """Write data end, summary and footer."""
        self.flush()
        self._put(_record(mcap.DATA_END, struct.pack("<I", self._crc)))
        start = self._offset
        summary, offsets = bytearray(), bytearray()
        for opcode, group in (
            (mcap.SCHEMA, b"".join(self._schemas)),
            (mcap.CHANNEL, b"".join(self._channels)),
            (mcap.STATISTICS, self._statistics()),
            (mcap.CHUNK_INDEX, bytes(self._chunk_indexes)),
            (mcap.METADATA_INDEX, bytes(self._metadata_indexes)),
        ):
            if group:
                place = struct.pack("<BQQ", opcode, start + len(summary), len(group))
                offsets += _record(mcap.SUMMARY_OFFSET, place)
                summary += group
        summary += offsets
        footer = _PREFIX.pack(mcap.FOOTER, 20) + struct.pack(
            "<QQ", start, start + len(summary) - len(offsets)
        )
        crc = zlib.crc32(footer, zlib.crc32(summary))
        self._put(bytes(summary) + footer + struct.pack("<I", crc) + mcap.MAGIC)

    def _statistics(self) -> bytes:
        first, last = self._times or (0, 0)
        counts = (
            struct.pack("<QH", self._counts.total(), len(self._schemas)),
            struct.pack("<IIII", len(self._channels), 0, self._metadata, self._chunks),
            struct.pack("<QQI", first, last, 10 * len(self._counts)),
            *(struct.pack("<HQ", channel, n) for channel, n in sorted(self._counts.items())),
        )
        return _record(mcap.STATISTICS, b"".join(counts))

    def _put(self, data: bytes | bytearray) -> None:
        self._stream.write(data)
        self._crc = zlib.crc32(data, self._crc)
        self._offset += len(data)
