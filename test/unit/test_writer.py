# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Session folders being written: chunks, metadata, full disks, killed processes, queues."""

import gc
import os
import resource
import signal
import subprocess
import sys
import threading
import tracemalloc
from contextlib import contextmanager

import pytest
import yaml
from mcap.reader import make_reader

from pmwvc_analysis.recorder_node import QUEUE_BYTES, BackgroundWriter
from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.salvage import RawMessage, Salvage, check_file, messages, recover
from pmwvc_analysis.recording.topics import Topic
from pmwvc_analysis.recording.writer import CHUNK_BYTES, SessionWriter
from pmwvc_core.errors import RecordingError
from pmwvc_core.runtime import messages as build
from pmwvc_core.transport.packet import WavePacket

SECOND = 1_000_000_000
TOPIC = Topic("/user1/wave_up", schemas.WAVE)


def packet(seq, epoch=7):
    """A serialized Wave."""
    store = schemas.typestore()
    types = build.types_from(store.types)
    content = WavePacket(epoch, seq, seq * 8_000_000, 0.008, 0.5, 0.004 * seq, 0.001 * seq, 0.0)
    return bytes(store.serialize_cdr(build.wave(types, content, seq * 8_000_000), schemas.WAVE))


def received(seq, at_ns):
    return RawMessage(TOPIC.name, TOPIC.type_name, at_ns, at_ns, packet(seq))


def write_some(writer, count, *, first=1, step_ns=8_000_000):
    for seq in range(first, first + count):
        writer.write(TOPIC.name, packet(seq), log_ns=seq * step_ns)


def stored(path):
    salvage = Salvage()
    return list(messages(path, salvage)), salvage


@contextmanager
def largest_file(size):
    """Let no file of this process grow beyond ``size``: writing fails as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_what_is_written_is_in_the_file(tmp_path):
    with SessionWriter(tmp_path / "a") as writer:
        writer.add_topic(TOPIC)
        writer.add_metadata("session", {"source": "live"})
        write_some(writer, 10)
    found, salvage = stored(writer.path)
    assert [message.data for message in found] == [packet(seq) for seq in range(1, 11)]
    assert found[0].topic == TOPIC.name
    assert salvage.metadata["session"] == {"source": "live"}
    assert salvage.end is None
    assert check_file(writer.path).whole


def test_a_chunk_is_at_most_a_second(tmp_path):
    with SessionWriter(tmp_path / "a") as writer:
        writer.add_topic(TOPIC)
        write_some(writer, 30, step_ns=SECOND // 10)
    assert check_file(writer.path).chunks == 3


def test_a_chunk_is_at_most_four_mebibytes(tmp_path):
    with SessionWriter(tmp_path / "a") as writer:
        writer.add_topic(TOPIC)
        write_some(writer, 3 * CHUNK_BYTES // len(packet(1)), step_ns=1000)
    with writer.path.open("rb") as stream:
        sizes = [
            chunk.uncompressed_size for chunk in make_reader(stream).get_summary().chunk_indexes
        ]
    assert CHUNK_BYTES - 200 < max(sizes) <= CHUNK_BYTES


def test_metadata_yaml_states_what_is_in_the_file(tmp_path):
    with SessionWriter(tmp_path / "a") as writer:
        writer.add_topic(TOPIC)
        writer.add_topic(Topic("/server/trace", schemas.SERVER_TRACE))
        write_some(writer, 10)
    content = yaml.safe_load((tmp_path / "a" / "metadata.yaml").read_text())
    information = content["rosbag2_bagfile_information"]
    assert information["version"] == 9
    assert information["message_count"] == 10
    assert information["relative_file_paths"] == ["session.mcap"]
    assert information["starting_time"]["nanoseconds_since_epoch"] == 8_000_000
    assert information["duration"]["nanoseconds"] == 9 * 8_000_000
    counts = {
        entry["topic_metadata"]["name"]: entry["message_count"]
        for entry in information["topics_with_message_count"]
    }
    assert counts == {"/user1/wave_up": 10, "/server/trace": 0}


def test_a_recording_is_never_overwritten(tmp_path):
    with SessionWriter(tmp_path):
        pass
    with pytest.raises(RecordingError, match=r"session\.mcap exists.*choose another folder"):
        SessionWriter(tmp_path)


def test_a_folder_that_cannot_be_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot record into"):
        SessionWriter(tmp_path / "file" / "session")


def test_a_full_disk_keeps_every_whole_chunk_and_reports_it(tmp_path):
    writer = SessionWriter(tmp_path / "a")
    writer.add_topic(TOPIC)
    write_some(writer, 100)
    writer.flush()
    kept = writer.path.stat().st_size
    with largest_file(kept + 100):
        write_some(writer, 1000, first=101)
        writer.flush()
        assert "kept up to the last whole chunk" in writer.problem
        writer.close()
    found, _ = stored(writer.path)
    assert len(found) == 100
    assert writer.path.stat().st_size == kept
    assert writer.refused == 1000


def test_a_disk_too_full_to_begin_is_refused_and_nothing_is_left(tmp_path):
    with pytest.raises(RecordingError, match=r"MiB left on the disk.*choose another folder"):
        SessionWriter(tmp_path / "a", reserve_bytes=1 << 62)
    assert not (tmp_path / "a" / "session.mcap").exists()


def test_running_out_of_space_ends_in_good_order(tmp_path, monkeypatch):
    writer = SessionWriter(tmp_path / "a")
    monkeypatch.setattr(writer, "_reserve", 1 << 62)
    writer.add_topic(TOPIC)
    write_some(writer, 10)
    writer.flush()
    assert "are kept free" in writer.problem
    write_some(writer, 5, first=11)
    writer.close()
    assert writer.refused == 5
    structure = check_file(writer.path)
    assert structure.whole
    assert structure.messages == 10


def test_closing_twice_does_no_harm(tmp_path):
    writer = SessionWriter(tmp_path / "a")
    writer.close()
    writer.close()
    assert check_file(writer.path).whole


def test_a_killed_process_leaves_everything_it_flushed(tmp_path):
    script = f"""
import sys; sys.path.insert(0, {os.path.dirname(os.path.dirname(__file__))!r})
import os, signal
sys.path.insert(0, {os.path.dirname(__file__)!r})
from test_writer import SessionWriter, TOPIC, write_some
writer = SessionWriter({str(tmp_path / "a")!r})
writer.add_topic(TOPIC)
writer.add_metadata("session", {{"source": "live"}})
write_some(writer, 100)
writer.flush()
writer.refresh_metadata()
write_some(writer, 10, first=101)
os.kill(os.getpid(), signal.SIGKILL)
"""
    done = subprocess.run([sys.executable, "-c", script], check=False)
    assert done.returncode == -signal.SIGKILL
    found, salvage = stored(tmp_path / "a" / "session.mcap")
    assert len(found) == 100
    assert salvage.end is not None
    assert salvage.metadata["session"] == {"source": "live"}
    content = yaml.safe_load((tmp_path / "a" / "metadata.yaml").read_text())
    assert content["rosbag2_bagfile_information"]["message_count"] == 100


def test_recovery_makes_a_whole_file_of_a_cut_one(tmp_path):
    with SessionWriter(tmp_path / "a") as writer:
        writer.add_topic(TOPIC)
        writer.add_metadata("session", {"source": "live"})
        write_some(writer, 300, step_ns=SECOND // 100)
    data = writer.path.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) // 2])
    salvage = recover(cut, tmp_path / "b")
    assert salvage.messages in (100, 200)
    found, again = stored(tmp_path / "b" / "session.mcap")
    assert [m.data for m in found] == [packet(seq) for seq in range(1, salvage.messages + 1)]
    assert again.metadata["session"] == {"source": "live"}
    assert "cut in the middle of a record" in again.metadata["recovered"]["cut"]
    assert check_file(tmp_path / "b" / "session.mcap").whole


def test_the_queue_never_waits_and_counts_what_it_loses(tmp_path):
    writer = SessionWriter(tmp_path / "a")
    writer.add_topic(TOPIC)
    entered, go_on = threading.Event(), threading.Event()
    write = writer.write

    def slow(*args, **kwargs):
        entered.set()
        go_on.wait()
        write(*args, **kwargs)

    writer.write = slow
    background = BackgroundWriter(writer, capacity_bytes=3 * len(packet(1)))
    background.put([received(1, SECOND)])
    entered.wait()
    for seq in range(2, 8):
        background.put([received(seq, SECOND + seq)])
    assert background.overrun == {TOPIC.name: 3}
    go_on.set()
    assert background.close() == [f"{TOPIC.name}: 3 did not fit the queue"]
    found, salvage = stored(writer.path)
    assert [m.data for m in found] == [packet(seq) for seq in range(1, 5)]
    assert salvage.metadata["losses"][TOPIC.name].endswith("3 not queued")


def test_missing_numbers_are_in_the_final_report(tmp_path):
    writer = SessionWriter(tmp_path / "a")
    writer.add_topic(TOPIC)
    background = BackgroundWriter(writer)
    background.put([received(s, SECOND + s) for s in (1, 2, 5, 6)])
    (line,) = background.close()
    assert line.startswith("/user1/wave_up: 2 of 6 missing")
    assert background.close() == [line]


def test_the_queue_holds_ten_seconds_of_eight_users():
    """41 topics at 125 Hz; the traces of masters, 900 bytes, are the largest of them."""
    assert QUEUE_BYTES > 10 * 41 * 125 * 900


def test_memory_does_not_grow_with_the_messages(tmp_path):
    """Ten minutes more may cost the index of 600 chunks, not their messages and not their gaps."""

    def minutes(writer, first, count):
        for row in range(first * 600, (first + count) * 600):
            for topic in topics:
                if row % 7:  # a gap every 0.7 s
                    writer.write(topic.name, packet(row + 1), log_ns=SECOND + row * SECOND // 10)
        writer.flush()
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    topics = [Topic(f"/user{number}/wave_up", schemas.WAVE) for number in range(3)]
    with SessionWriter(tmp_path / "a") as writer:
        for topic in topics:
            writer.add_topic(topic)
        tracemalloc.start()
        try:
            minutes(writer, 0, 8)
            before = minutes(writer, 8, 2)
            after = minutes(writer, 10, 10)
        finally:
            tracemalloc.stop()
    per_index = 400 + 50 * len(topics)  # as the library keeps it
    assert after - before < 1.5 * 600 * per_index
    assert check_file(writer.path).whole
    assert writer.counter.missing(topics[0].name) == len(range(0, 12_000, 7))
