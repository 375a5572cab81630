# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The structural check of MCAP files: each kind of damage is found by the check made for it.

The files are written without checksums, so that no checksum finds the damage first.
"""

import io
import struct

import pytest
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC as MAGIC
from mcap.writer import CompressionType, Writer

from pmwvc_analysis.recording.mcap.mcap_check import check_bytes
from pmwvc_analysis.recording.mcap.mcap_records import PREFIX, records

MESSAGES = 40


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
    end = len(data) - len(MAGIC)
    known = [r for r in records(memoryview(data), len(MAGIC), end) if r.opcode == opcode]
    return known[place].offset


def patched(data, offset, form, value):
    changed = bytearray(data)
    struct.pack_into(form, changed, offset, value)
    return bytes(changed)


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
    "statistics: messages": (
        (Opcode.STATISTICS, 0, P, "<Q", 7),
        "message_count = 7, not 40",
    ),
    "statistics: schemas": (
        (Opcode.STATISTICS, 0, P + 8, "<H", 3),
        "schema_count = 3, not 1",
    ),
    "statistics: chunks": (
        (Opcode.STATISTICS, 0, P + 22, "<I", 9),
        "chunk_count = 9, not 5",
    ),
    "statistics: times": (
        (Opcode.STATISTICS, 0, P + 26, "<Q", 5),
        "message_start_time = 5, not 1000",
    ),
    "statistics: per channel": (
        (Opcode.STATISTICS, 0, P + 48, "<Q", 1),
        "has channel_message_counts = ",
    ),
    "chunk index: offset": (
        (Opcode.CHUNK_INDEX, 0, P + 16, "<Q", 77),
        "names byte 77: no such record",
    ),
    "chunk index: time": (
        (Opcode.CHUNK_INDEX, 0, P, "<Q", 1),
        "message_start_time = 1, not",
    ),
    "chunk index: message index": (
        (Opcode.CHUNK_INDEX, 0, P + 38, "<Q", 3),
        "has message_index_offsets = ",
    ),
    "chunk index: length of indexes": (
        (Opcode.CHUNK_INDEX, 0, P + 56, "<Q", 3),
        "has message_index_length = 3, not",
    ),
    "message index: gone": (
        (Opcode.MESSAGE_INDEX, 1, 0, "<B", 0x81),
        "has messages without an index",
    ),
    "message index: time": ((Opcode.MESSAGE_INDEX, 0, P + 6, "<Q", 3), "does not fit its chunk"),
    "message index: offset": (
        (Opcode.MESSAGE_INDEX, 1, P + 14, "<Q", 3),
        "does not fit its chunk",
    ),
    "message index: channel": ((Opcode.MESSAGE_INDEX, 0, P, "<H", 9), "does not fit its chunk"),
    "metadata index": ((Opcode.METADATA_INDEX, 0, P, "<Q", 8), "metadata-index at byte"),
    "attachment index": (
        (Opcode.ATTACHMENT_INDEX, 0, P + 8, "<Q", 8),
        "has length = 8, not",
    ),
    "summary offset: start": (
        (Opcode.SUMMARY_OFFSET, 0, P + 1, "<Q", 5),
        "has group_start = 5, not",
    ),
    "summary offset: length": (
        (Opcode.SUMMARY_OFFSET, 3, P + 9, "<Q", 5),
        "has group_length = 5, not",
    ),
    "footer: summary": (
        (Opcode.FOOTER, 0, P, "<Q", 30),
        "has summary_start = 30, not",
    ),
    "footer: offsets": (
        (Opcode.FOOTER, 0, P + 8, "<Q", 31),
        "has summary_offset_start = 31, not",
    ),
    "repeated schema": (
        (Opcode.SCHEMA, 0, P + 6, "<B", 90),
        "has name = 'Z/msg/B', not 'a/msg/B'",
    ),
    "repeated channel": (
        (Opcode.CHANNEL, 0, P + 8, "<B", 90),
        "has topic = 'Ztopic0', not '/topic0'",
    ),
    "chunk: first time": (
        (Opcode.CHUNK, 0, P, "<Q", 5),
        "names times that its messages",
    ),
    "chunk: size": ((Opcode.CHUNK, 0, P + 16, "<Q", 5), "bytes, not 5"),
    "chunk: checksum": ((Opcode.CHUNK, 0, P + 24, "<I", 5), "the checksum of the chunk"),
    "data section: checksum": ((Opcode.DATA_END, 0, P, "<I", 5), "checksum of the data section"),
    "summary: checksum": ((Opcode.FOOTER, 0, P + 16, "<I", 5), "the checksum of the summary"),
    "attachment: content": ((Opcode.ATTACHMENT, 0, P, "<B", 90), "checksum of the attachment"),
    "attachment index: size": (
        (Opcode.ATTACHMENT_INDEX, 0, P + 32, "<Q", 8),
        "has data_size = 8, not 9",
    ),
    "attachment index: name": (
        (Opcode.ATTACHMENT_INDEX, 0, P + 44, "<B", 90),
        "has name = 'Zotes'",
    ),
    "attachment index: text": (
        (Opcode.ATTACHMENT_INDEX, 0, P + 40, "<I", 99),
        "contradicts its own lengths",
    ),
    "metadata index: name": (
        (Opcode.METADATA_INDEX, 0, P + 20, "<B", 90),
        "has name = 'Zession'",
    ),
    "metadata index: text": (
        (Opcode.METADATA_INDEX, 0, P + 16, "<I", 99),
        "contradicts its own lengths",
    ),
    "metadata: name": ((Opcode.METADATA, 0, P, "<I", 99), "contradicts its own lengths"),
    "metadata: no UTF-8": ((Opcode.METADATA, 0, P + 4, "<B", 255), "not UTF-8"),
    "metadata: map": ((Opcode.METADATA, 0, P + 11, "<I", 3), "contradicts its own lengths"),
    "metadata: key": ((Opcode.METADATA, 0, P + 15, "<I", 99), "contradicts its own lengths"),
    "attachment: size": ((Opcode.ATTACHMENT, 0, P + 39, "<Q", 99), "contradicts its own lengths"),
    "record: length": ((Opcode.CHUNK, 1, 1, "<Q", 1 << 40), "are left"),
    "record: kind": ((Opcode.CHUNK, 1, 0, "<B", 1), "the header has to come first"),
    "data end: gone": ((Opcode.DATA_END, 0, 0, "<B", 0x80), "record in the data section"),
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
    assert "channel 9, defined nowhere" in problems(patched(data, start + P, "<H", 9))


def test_magic_is_wanted_at_both_ends():
    data = written()
    assert "does not begin as" in problems(b"X" + data[1:])
    assert "was not closed" in problems(data[:-1])


def test_a_file_without_its_summary_is_reported_as_unfinished():
    data = written()
    assert "there is no data-end record" in problems(data[: found(data, Opcode.DATA_END)])


@pytest.mark.parametrize("data", [b"", b"\x89MCAP0\r\n", bytes(100), b"\x89MCAP0\r\n" * 2])
def test_a_file_that_is_no_mcap_is_reported(data):
    assert not check_bytes(data).whole


def test_a_long_list_of_problems_is_shortened():
    data = written()
    for place in range(2):
        offset = found(data, Opcode.CHANNEL, place)
        data = patched(data, offset + P + 2, "<H", 7)
    assert len(check_bytes(data).problems) <= 51
