# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The records of an MCAP file with their offsets, which the library's readers do not give.

The library parses the fields of a record, leniently: where a length is wrong it stops short or
reads on. A record counts as parsed only if the library writes the same bytes again.
"""

import struct
from collections.abc import Iterator
from io import BytesIO
from typing import NamedTuple

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
