# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Session folders being written: chunks, metadata, full disks, killed processes, queues."""

import gc
import resource
import struct
import tracemalloc
from contextlib import contextmanager

import pytest
import yaml
from mcap.reader import make_reader

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.salvage import Salvage, messages
from pmwvc_analysis.recording.topics import Topic
from pmwvc_analysis.recording.writer import CHUNK_BYTES, SessionWriter
from pmwvc_core.errors import RecordingError
from pmwvc_core.runtime import messages as build
from pmwvc_core.transport.packet import WavePacket

SECOND = 1_000_000_000
TOPIC = Topic("/user1/wave_up", schemas.WAVE)
STORE = schemas.typestore()
FIRST = build.wave(
    build.types_from(STORE.types), WavePacket(7, 1, 0, 0.008, 0.5, 0.4, 0.1, 0.0), 0
)
SERIALIZED = bytes(STORE.serialize_cdr(FIRST, schemas.WAVE))
SEQ_AT = 28  # CDR header, stamp, clock, epoch


def packet(seq):
    """A serialized Wave with a number."""
    return SERIALIZED[:SEQ_AT] + struct.pack("<I", seq) + SERIALIZED[SEQ_AT + 4 :]


def write_some(writer, count, *, first=1, step_ns=8_000_000):
    for seq in range(first, first + count):
        writer.write(TOPIC.name, packet(seq), log_ns=seq * step_ns)


def begun(folder):
    writer = SessionWriter(folder)
    writer.add_topic(TOPIC)
    writer.add_metadata("session", {"source": "live"})
    return writer


def stored(path):
    salvage = Salvage()
    return [message.data for message in messages(open(path, "rb"), salvage)], salvage


def packets(count):
    return [packet(seq) for seq in range(1, count + 1)]


@contextmanager
def largest_file(size):
    """Let no file of this process grow beyond ``size``: writing fails as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_what_is_written_is_in_the_file_and_in_its_metadata(tmp_path):
    with begun(tmp_path / "a") as writer:
        writer.add_topic(Topic("/server/trace", schemas.SERVER_TRACE))
        write_some(writer, 10)
    found, salvage = stored(writer.path)
    assert (found, salvage.end, salvage.whole) == (packets(10), None, True)
    assert list(salvage.topics) == [TOPIC.name, "/server/trace"]
    assert salvage.metadata["session"] == {"source": "live"}
    content = yaml.safe_load((tmp_path / "a" / "metadata.yaml").read_text())
    information = content["rosbag2_bagfile_information"]
    assert (information["version"], information["message_count"]) == (9, 10)
    assert information["relative_file_paths"] == ["session.mcap"]
    assert information["starting_time"]["nanoseconds_since_epoch"] == 8_000_000
    assert information["duration"]["nanoseconds"] == 9 * 8_000_000
    topics = information["topics_with_message_count"]
    counts = {each["topic_metadata"]["name"]: each["message_count"] for each in topics}
    assert counts == {"/user1/wave_up": 10, "/server/trace": 0}
    writer.close()  # twice does no harm
    assert stored(writer.path)[1].whole


def test_a_chunk_is_at_most_a_second_and_ends_at_four_mebibytes(tmp_path):
    with begun(tmp_path / "a") as writer:
        write_some(writer, 30, step_ns=SECOND // 10)
    assert stored(writer.path)[1].chunks == 3
    with begun(tmp_path / "b") as writer:
        write_some(writer, 2 * CHUNK_BYTES // len(packet(1)), step_ns=1000)
    with writer.path.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    assert CHUNK_BYTES <= max(each.uncompressed_size for each in chunks) < CHUNK_BYTES + 200


def test_where_nothing_can_be_recorded_is_refused_and_nothing_is_left(tmp_path):
    begun(tmp_path / "a").close()
    with pytest.raises(RecordingError, match=r"session\.mcap exists.*choose another folder"):
        SessionWriter(tmp_path / "a")
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot record into"):
        SessionWriter(tmp_path / "file" / "session")
    with pytest.raises(RecordingError, match=r"MiB left on the disk.*choose another folder"):
        SessionWriter(tmp_path / "b", reserve_bytes=1 << 62)
    assert not (tmp_path / "b" / "session.mcap").exists()


def test_a_full_disk_keeps_every_full_second_and_reports_it(tmp_path):
    writer = begun(tmp_path / "a")
    write_some(writer, 100)
    writer.flush()
    kept = writer.path.stat().st_size
    with largest_file(kept + 100):
        write_some(writer, 1000, first=101)
        writer.flush()
        assert "kept up to the last full second" in writer.problem
        writer.close()
    assert stored(writer.path)[0] == packets(100)
    assert writer.path.stat().st_size == kept
    assert writer.refused == 1000


def test_running_out_of_space_ends_in_good_order(tmp_path, monkeypatch):
    writer = begun(tmp_path / "a")
    monkeypatch.setattr(writer, "_reserve", 1 << 62)
    write_some(writer, 10)
    writer.flush()
    assert "are kept free" in writer.problem
    write_some(writer, 5, first=11)
    writer.close()
    assert writer.refused == 5
    assert stored(writer.path)[0] == packets(10) and stored(writer.path)[1].whole


def test_memory_does_not_grow_with_the_messages(tmp_path):
    """Five minutes more may cost the index of 300 chunks, no messages."""

    def minutes(writer, first, count):
        for row in range(first * 600, (first + count) * 600):
            if row % 7:  # a gap every 0.7 s
                writer.write(TOPIC.name, packet(row + 1), log_ns=SECOND + row * SECOND // 10)
        writer.flush()
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    with begun(tmp_path / "a") as writer:
        tracemalloc.start()
        try:
            minutes(writer, 0, 4)
            before, after = minutes(writer, 4, 1), minutes(writer, 5, 5)
        finally:
            tracemalloc.stop()
    per_index = 450  # as the library keeps it
    assert after - before < 1.5 * 300 * per_index
