# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The check of MCAP files: with checksums every byte counts; without, what can be told."""

import io
import struct

import pytest
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC as MAGIC
from mcap.writer import CompressionType, Writer

from pmwvc_analysis.recording.salvage import Salvage, messages_in

MESSAGES = 40
PREFIX = struct.Struct("<BQ")  # opcode and length in front of every record


def written(*, crcs=False, compression=CompressionType.NONE, attachment=True):
    """The bytes of a file with two channels in five chunks."""
    stream = io.BytesIO()
    writer = Writer(
        stream,
        chunk_size=500,
        compression=compression,
        enable_crcs=crcs,
        enable_data_crcs=crcs,
    )
    writer.start("ros2", "test")
    schema = writer.register_schema("a/msg/B", "ros2msg", b"int32 x\n")
    channels = [writer.register_channel(f"/topic{i}", "cdr", schema) for i in range(2)]
    writer.add_metadata("session", {"source": "live"})
    for place in range(MESSAGES):
        writer.add_message(channels[place % 2], 1000 + place, bytes(20), 1000 + place, place)
    if attachment:
        writer.add_attachment(1, 2, "notes", "text/plain", b"something")
    writer.finish()
    return stream.getvalue()


def found(data, opcode, place=0):
    """The offset of a record at the top level."""
    at, known = len(MAGIC), []
    while at < len(data) - len(MAGIC):
        kind, length = PREFIX.unpack_from(data, at)
        known += [at] * (kind == opcode)
        at += PREFIX.size + length
    return known[place]


def patched(data, offset, form, value):
    changed = bytearray(data)
    struct.pack_into(form, changed, offset, value)
    return bytes(changed)


def check_bytes(data):
    found = Salvage()
    list(messages_in(io.BytesIO(data), found))
    return found


def problems(data):
    return "\n".join(check_bytes(data).problems)


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD])
def test_a_sound_file_has_no_problem(compression):
    structure = check_bytes(written(crcs=True, compression=compression))
    assert structure.problems == []
    assert structure.notes == []
    assert structure.messages == MESSAGES


def test_missing_checksums_are_named_but_no_damage():
    structure = check_bytes(written())
    assert structure.whole
    assert "no checksum of the summary" in structure.notes
    assert "no checksum of the data section" in structure.notes


P = PREFIX.size
DAMAGE = {
    # what: (record, its place, offset in it, form, value), words in the finding
    "statistics: chunks": ((Opcode.STATISTICS, 0, P + 22, "<I", 9), "statistics do not fit"),
    "statistics: per channel": ((Opcode.STATISTICS, 0, P + 48, "<Q", 1), "statistics do not fit"),
    "chunk: checksum": ((Opcode.CHUNK, 0, P + 24, "<I", 5), "crc validation failed in Chunk"),
    "data section: checksum": ((Opcode.DATA_END, 0, P, "<I", 5), "crc validation failed in Data"),
    "summary: checksum": ((Opcode.FOOTER, 0, P + 16, "<I", 5), "the checksum of the summary"),
    "metadata: name": ((Opcode.METADATA, 0, P, "<I", 99), "the file is damaged"),
    "metadata: no UTF-8": ((Opcode.METADATA, 0, P + 4, "<B", 255), "the file is damaged"),
    "attachment: size": ((Opcode.ATTACHMENT, 0, P + 39, "<Q", 99), "the file is damaged"),
    "record: length": ((Opcode.CHUNK, 1, 1, "<Q", 1 << 40), "exceeds limit"),
    "data end: gone": ((Opcode.DATA_END, 0, 0, "<B", 0x80), "there is no end of the data"),
    "data end: length": ((Opcode.DATA_END, 0, 1, "<Q", 0), "there is no end of the data"),
}


@pytest.mark.parametrize("what", DAMAGE)
def test_damage_is_found_where_it_is(what):
    (opcode, place, offset, form, value), words = DAMAGE[what]
    data = written()
    assert words in problems(patched(data, found(data, opcode, place) + offset, form, value))


def test_a_message_moved_to_another_channel_is_found():
    data = written()
    chunk = found(data, Opcode.CHUNK, 1)
    start = data.index(bytes([Opcode.MESSAGE]) + struct.pack("<Q", 42), chunk)
    assert "channel 9, which is defined nowhere" in problems(patched(data, start + P, "<H", 9))


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD])
def test_with_checksums_every_byte_counts(compression):
    data = written(crcs=True, compression=compression)
    for place, value in enumerate(data):
        assert problems(patched(data, place, "<B", value ^ 4)), place


def test_magic_is_wanted_at_both_ends():
    data = written()
    assert "invalid magic" in problems(b"X" + data[1:])
    assert "it was not closed" in problems(data[:-1])
    assert "bytes follow" in problems(data + b"x")


def test_a_file_without_its_summary_is_reported_as_unfinished():
    data = written()
    assert "it was not closed" in problems(data[: found(data, Opcode.DATA_END)])


@pytest.mark.parametrize("data", [b"", b"\x89MCAP0\r\n", bytes(100), b"\x89MCAP0\r\n" * 2])
def test_a_file_that_is_no_mcap_is_reported(data):
    assert not check_bytes(data).whole
