# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Our recordings read by the readers of other projects, and damaged at any byte."""

import io
import json
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from support import handmade

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.salvage import Salvage, messages, messages_in
from pmwvc_core.runtime.messages import nanoseconds

DURATION_S = 0.8
START_NS = handmade.START_NS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("session")
    traces = handmade.session(duration_s=DURATION_S, users=1)
    scenario = handmade.scenario(duration_s=DURATION_S, users=1)
    record_traces(place, traces, scenario, start_ns=START_NS)
    return place


@pytest.fixture(scope="module")
def data(folder):
    return (folder / "session.mcap").read_bytes()


@pytest.mark.parametrize("bare", [False, True])
def test_rosbags_reads_folder_and_bare_file(folder, bare):
    traces = handmade.session(duration_s=DURATION_S, users=1)
    with AnyReader([folder / "session.mcap" if bare else folder]) as reader:
        assert reader.message_count == sum(1 for _ in reader.messages())
        (connection,) = [c for c in reader.connections if c.topic == "/user1/wave_up"]
        waves = [
            reader.deserialize(raw, connection.msgtype)
            for connection, _, raw in reader.messages([connection])
        ]
        assert connection.ext.offered_qos_profiles[0].depth == 10_000
    expected = traces.packets["/user1/wave_up"]
    assert [message.seq for message in waves] == expected.seq.tolist()
    assert [message.wave[0] for message in waves] == expected.wave[:, 0].tolist()
    assert nanoseconds(waves[0].stamp) == START_NS


def test_the_reader_of_mcap_itself_finds_everything_by_index(folder, data):
    reader = make_reader(io.BytesIO(data), validate_crcs=True)
    summary = reader.get_summary()
    counted = sum(1 for _ in reader.iter_messages())
    assert counted == summary.statistics.message_count
    topics = {channel.topic for channel in summary.channels.values()}
    assert "/server/user1/wave_down" in topics
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
        assert schemas.hash_of(schemas.schema_text(type_name), type_name) == hashes[type_name]


def check_bytes(data):
    found = Salvage()
    list(messages_in(io.BytesIO(data), found))
    return found


def whole_chunks(data):
    """Where each chunk ends, and how many messages there are up to there, by the file's index."""
    reader = make_reader(io.BytesIO(data))
    ends, total = [], 0
    indexes = sorted(reader.get_summary().chunk_indexes, key=lambda i: i.chunk_start_offset)
    for index in indexes:
        channels = len(index.message_index_offsets)
        # 9 bytes of prefix, 2 of channel and 4 of length per message index, 16 per message
        total += (index.message_index_length - 15 * channels) // 16
        ends.append((index.chunk_start_offset + index.chunk_length, total))
    return ends


@settings(max_examples=60)
@given(share=st.floats(0.0, 1.0))
def test_a_file_cut_anywhere_gives_back_every_whole_chunk(data, tmp_path_factory, share):
    size = round(share * (len(data) - 1))
    expected = max((count for end, count in whole_chunks(data) if end <= size), default=0)
    path = tmp_path_factory.getbasetemp() / "cut.mcap"
    path.write_bytes(data[:size])
    salvage = Salvage()
    found = list(messages(path, salvage))
    assert len(found) == expected
    assert salvage.end is not None
    assert not check_bytes(data[:size]).whole


@settings(max_examples=100)
@given(share=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_a_changed_bit_anywhere_is_found(data, share, bit):
    changed = bytearray(data)
    changed[int(share * len(data))] ^= 1 << bit
    assert not check_bytes(bytes(changed)).whole


@settings(max_examples=100)
@given(share=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_a_changed_bit_never_gives_back_a_wrong_message(data, tmp_path_factory, share, bit):
    path = tmp_path_factory.getbasetemp() / "whole.mcap"
    path.write_bytes(data)
    originals = [message.data for message in messages(path, Salvage())]
    ends = [8, *(end for end, _ in whole_chunks(data))]
    changed = bytearray(data)
    changed[int(ends[0] + share * (ends[-1] - ends[0]))] ^= 1 << bit  # somewhere in the chunks
    path.write_bytes(changed)
    found = [message.data for message in messages(path, Salvage())]
    assert found == originals[: len(found)]


def test_the_file_itself_is_whole(data):
    structure = check_bytes(data)
    assert structure.problems == []
    assert structure.notes == []


@settings(max_examples=60)
@given(garbage=st.binary(max_size=400))
def test_garbage_behind_a_magic_does_no_harm(garbage):
    assert not check_bytes(b"\x89MCAP0\r\n" + garbage).whole
