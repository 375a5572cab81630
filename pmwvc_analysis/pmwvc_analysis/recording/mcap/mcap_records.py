# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The records of an MCAP file, parsed from its bytes by the specification, for checking only.

Independent of the library that writes them, and strict: a field that does not fit its record
raises.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX = range(9, 14)
SUMMARY_OFFSET, DATA_END = 14, 15
NAMES = (
    "header footer schema channel message chunk message-index chunk-index attachment "
    "attachment-index statistics metadata metadata-index summary-offset data-end"
).split()
PREFIX = 9  # opcode and length in front of every record

Buffer = bytes | memoryview


class Malformed(Exception):
    """Bytes that are not what the specification wants; the message says where and what."""


def name_of(opcode: int) -> str:
    """Return a record's kind in words."""
    return NAMES[opcode - 1] if 1 <= opcode <= len(NAMES) else f"unknown (opcode {opcode})"


@dataclass(frozen=True)
class Record:
    """One record: kind, where it starts in its buffer, and its content."""

    opcode: int
    offset: int
    content: Buffer

    @property
    def size(self) -> int:
        """Bytes of the whole record."""
        return PREFIX + len(self.content)

    @property
    def end(self) -> int:
        """Offset behind the record."""
        return self.offset + self.size

    def fields(self) -> "Fields":
        """Return a reader of the content."""
        return Fields(self)


def records(buffer: Buffer, start: int, end: int) -> Iterator[Record]:
    """Yield records one behind the other; raise where the next one does not fit."""
    offset = start
    while offset < end:
        if offset + PREFIX > end:
            raise Malformed(f"at byte {offset}: {end - offset} bytes are no record")
        opcode, length = struct.unpack_from("<BQ", buffer, offset)
        if offset + PREFIX + length > end:
            raise Malformed(
                f"at byte {offset}: a {name_of(opcode)} record of {length} bytes, "
                f"{end - offset - PREFIX} are left"
            )
        yield Record(opcode, offset, buffer[offset + PREFIX : offset + PREFIX + length])
        offset += PREFIX + length


class Fields:
    """Reads the fields of one record in order."""

    def __init__(self, record: Record) -> None:
        self._record = record
        self._place = 0

    def _take(self, size: int) -> Buffer:
        content = self._record.content
        if self._place + size > len(content):
            raise Malformed(
                f"at byte {self._record.offset}: a field of the {name_of(self._record.opcode)} "
                "record reaches beyond its end"
            )
        self._place += size
        return content[self._place - size : self._place]

    def number(self, size: int) -> int:
        """Return an unsigned number of ``size`` bytes."""
        return int.from_bytes(self._take(size), "little")

    def numbers(self, *sizes: int) -> tuple[int, ...]:
        """Return several numbers."""
        return tuple(self.number(size) for size in sizes)

    def text(self) -> str:
        """Return a text with its length in front."""
        raw = bytes(self._take(self.number(4)))
        try:
            return raw.decode("utf-8")
        except UnicodeDecodeError as error:
            raise Malformed(f"at byte {self._record.offset}: a text is not UTF-8") from error

    def block(self, size_bytes: int) -> Buffer:
        """Return bytes with their length, a number of ``size_bytes``, in front."""
        return self._take(self.number(size_bytes))

    def rest(self) -> Buffer:
        """Return everything that is left."""
        return self._take(len(self._record.content) - self._place)

    def mapping(self, key: int, value: int) -> list[tuple[int, int]]:
        """Return pairs of numbers with their length in bytes in front."""
        raw = self.block(4)
        if len(raw) % (key + value):
            raise Malformed(f"at byte {self._record.offset}: a map of {len(raw)} bytes")
        step = key + value
        return [
            (
                int.from_bytes(raw[i : i + key], "little"),
                int.from_bytes(raw[i + key : i + step], "little"),
            )
            for i in range(0, len(raw), step)
        ]

    def texts(self) -> dict[str, str]:
        """Return pairs of texts with their length in bytes in front."""
        size = self.number(4)
        end = self._place + size
        found = {}
        while self._place < end:
            name = self.text()
            found[name] = self.text()
        if self._place != end:
            raise Malformed(f"at byte {self._record.offset}: a map of {size} bytes")
        return found
