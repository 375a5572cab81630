# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Our recordings read by the readers of other projects, and files damaged at any byte."""

import io
import json
import struct
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC as MAGIC
from mcap.writer import CompressionType, Writer
from rosbags.highlevel import AnyReader
from support import handmade

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.salvage import Salvage, messages
from pmwvc_core.runtime.messages import nanoseconds

TRACES = handmade.session(duration_s=0.8, users=1)
START_NS = handmade.START_NS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("session")
    scenario = handmade.scenario(duration_s=0.8, users=1)
    record_traces(place, TRACES, scenario, start_ns=START_NS)
    return place


@pytest.fixture(scope="module")
def data(folder):
    return (folder / "session.mcap").read_bytes()


def read(data):
    """The messages that a file gives back, and what is said of it."""
    found = Salvage()
    return list(messages(io.BytesIO(data), found)), found


@pytest.mark.parametrize("bare", [False, True])
def test_rosbags_reads_folder_and_bare_file(folder, bare):
    with AnyReader([folder / "session.mcap" if bare else folder]) as reader:
        assert reader.message_count == sum(1 for _ in reader.messages())
        (connection,) = [c for c in reader.connections if c.topic == "/user1/wave_up"]
        waves = [
            reader.deserialize(raw, connection.msgtype)
            for connection, _, raw in reader.messages([connection])
        ]
        assert connection.ext.offered_qos_profiles[0].depth == 10_000
    expected = TRACES.packets["/user1/wave_up"]
    assert [message.seq for message in waves] == expected.seq.tolist()
    assert [message.wave[0] for message in waves] == expected.wave[:, 0].tolist()
    assert nanoseconds(waves[0].stamp) == START_NS


def test_the_reader_of_mcap_itself_finds_everything_by_index(data):
    reader = make_reader(io.BytesIO(data), validate_crcs=True)
    summary = reader.get_summary()
    assert sum(1 for _ in reader.iter_messages()) == summary.statistics.message_count
    assert "/server/user1/wave_down" in {each.topic for each in summary.channels.values()}
    names = {record.name for record in reader.iter_metadata()}
    assert {"session", "parameters", "software", "rosbag2"} <= names
    late = START_NS + 500_000_000
    for _, channel, message in reader.iter_messages(topics="/user1/trace", starting_at=late):
        assert channel.topic == "/user1/trace"
        assert message.log_time >= late


def test_hashes_of_types_are_those_that_ros_computed():
    share = Path(sys.prefix) / "share" / "pmwvc_msgs" / "msg"
    if not share.is_dir():
        pytest.skip("pmwvc_msgs is not built here")
    for type_name in schemas.OUR_TYPES:
        known = json.loads((share / f"{type_name.rpartition('/')[2]}.json").read_text())
        hashes = {entry["type_name"]: entry["hash_string"] for entry in known["type_hashes"]}
        store = schemas.store_of((schemas.schema_text(type_name), type_name))
        assert store.hash_rihs01(type_name) == hashes[type_name]


def whole_chunks(data):
    """Where each chunk ends, and how many messages there are up to there, by the file's index."""
    ends, total = [], 0
    indexes = make_reader(io.BytesIO(data)).get_summary().chunk_indexes
    for index in sorted(indexes, key=lambda each: each.chunk_start_offset):
        channels = len(index.message_index_offsets)
        # 9 bytes of prefix, 2 of channel and 4 of length per message index, 16 per message
        total += (index.message_index_length - 15 * channels) // 16
        ends.append((index.chunk_start_offset + index.chunk_length, total))
    return ends


@settings(max_examples=20)
@given(share=st.floats(0.0, 1.0))
def test_a_file_cut_anywhere_gives_back_every_whole_chunk(data, share):
    size = round(share * (len(data) - 1))
    expected = max((count for end, count in whole_chunks(data) if end <= size), default=0)
    found, salvage = read(data[:size])
    assert len(found) == expected
    assert salvage.end is not None and not salvage.whole


def end_of_data(data):
    """The place behind which only indexes follow, which nothing here reads."""
    at = len(MAGIC)
    while data[at] != Opcode.DATA_END:
        at += P + PREFIX.unpack_from(data, at)[1]
    return at


@settings(max_examples=40)
@given(share=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_a_changed_bit_of_the_data_is_found_and_gives_back_no_wrong_message(data, share, bit):
    originals, sound = read(data)
    assert sound.whole
    place = int(share * end_of_data(data))
    changed = bytearray(data)
    changed[place] ^= 1 << bit
    found, salvage = read(changed)
    assert not salvage.whole
    if MAGIC.__len__() <= place < whole_chunks(data)[-1][0]:  # somewhere in the chunks
        assert found == originals[: len(found)]


@settings(max_examples=20)
@given(garbage=st.binary(max_size=400))
def test_garbage_behind_a_magic_does_no_harm(garbage):
    assert not read(MAGIC + garbage)[1].whole


PREFIX = struct.Struct("<BQ")  # opcode and length in front of every record
P = PREFIX.size


def written(*, crcs=False, compression=CompressionType.NONE):
    """The bytes of another tool's file with two channels in five chunks."""
    stream = io.BytesIO()
    options = {"compression": compression, "enable_crcs": crcs, "enable_data_crcs": crcs}
    writer = Writer(stream, chunk_size=500, **options)
    writer.start("ros2", "test")
    schema = writer.register_schema("a/msg/B", "ros2msg", b"int32 x\n")
    channels = [writer.register_channel(f"/topic{i}", "cdr", schema) for i in range(2)]
    writer.add_metadata("session", {"source": "live"})
    for place in range(40):
        writer.add_message(channels[place % 2], 1000 + place, bytes(20), 1000 + place, place)
    writer.add_attachment(1, 2, "notes", "text/plain", b"something")
    writer.finish()
    return stream.getvalue()


def patched(data, offset, form, value):
    changed = bytearray(data)
    struct.pack_into(form, changed, offset, value)
    return bytes(changed)


def problems(data):
    return "\n".join(read(data)[1].problems)


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD])
def test_with_checksums_every_byte_of_the_data_counts(compression):
    data = written(crcs=True, compression=compression)
    messages, sound = read(data)
    assert (len(messages), sound.problems) == (40, [])
    for place, value in enumerate(data[: end_of_data(data)]):
        assert problems(patched(data, place, "<B", value ^ 4)), place


@pytest.mark.parametrize(
    ("opcode", "place", "offset", "form", "value", "words"),
    [
        (Opcode.STATISTICS, 0, P + 22, "<I", 9, "the statistics do not fit"),
        (Opcode.STATISTICS, 0, P + 48, "<Q", 1, "the statistics do not fit"),
        (Opcode.CHUNK, 0, P + 24, "<I", 5, "crc validation failed in Chunk"),
        (Opcode.CHUNK, 1, 1, "<Q", 1 << 40, "exceeds limit"),
        (Opcode.CHUNK, 1, P + 49, "<H", 9, "channel 9, which is defined nowhere"),
        (Opcode.DATA_END, 0, P, "<I", 5, "crc validation failed in Data"),
        (Opcode.METADATA, 0, P, "<I", 99, "the file is damaged"),
        (Opcode.ATTACHMENT, 0, P + 39, "<Q", 99, "the file is damaged"),
    ],
)
def test_without_checksums_damage_of_the_structure_is_found(
    opcode, place, offset, form, value, words
):
    data, at, known = written(), len(MAGIC), []
    salvage = read(data)[1]
    assert salvage.whole
    while at < len(data) - len(MAGIC):
        kind, length = PREFIX.unpack_from(data, at)
        known += [at] * (kind == opcode)
        at += P + length
    assert words in problems(patched(data, known[place] + offset, form, value))
    assert "it was not closed" in problems(data[:-1])
    assert "bytes follow" in problems(data + b"x")
