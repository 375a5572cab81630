# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The recorder as a process of its own; the test publishes a session's topics."""

import resource
import signal

import pytest
import yaml
from support.peers import ros
from support.processes import NodeProcess, refused

from pmwvc_analysis.recorder_node import main
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.recording.salvage import Salvage, messages
from pmwvc_core.runtime import messages as build
from pmwvc_core.runtime.messages import record_of
from pmwvc_core.transport.packet import WavePacket
from pmwvc_msgs.msg import MasterTrace, ServerTrace, Wave

pytestmark = pytest.mark.integration
MODULE = "pmwvc_analysis.recorder_node"
TYPES = build.live_types()
UP, DOWN = "/user1/wave_up", "/user1/wave_down"


class Session:
    """Publishers on every topic of one user without an emulated network."""

    def __init__(self, peer):
        self.peer = peer
        self.waves = [
            peer.publisher(Wave, record_of(topic), reliable=True) for topic in (UP, DOWN)
        ]
        peer.publisher(MasterTrace, "/user1/trace", reliable=True)
        peer.publisher(ServerTrace, "/server/trace", reliable=True)
        self.sent = 0

    def send(self, count, *, skip=()):
        """Publish waves both ways to a matched recorder, numbered on; but those in ``skip``."""
        self.peer.until(lambda: all(each.get_subscription_count() for each in self.waves))
        for _ in range(count):
            self.sent += 1
            packet = WavePacket(9, self.sent, 8 * self.sent, 0.008, 0.5, 0.1, 0.2, 0.3)
            for publisher in self.waves if self.sent not in skip else ():
                publisher.publish(build.wave(TYPES, packet, 8_000_000 * self.sent))

    def in_file(self, folder, count):
        """Wait until the recorder has flushed so many messages."""

        def flushed():
            path = folder / "metadata.yaml"
            if not path.is_file():
                return False
            content = yaml.safe_load(path.read_text())["rosbag2_bagfile_information"]
            return content["message_count"] >= count

        self.peer.until(flushed)


def values(place, **parameters):
    usual = {"folder": str(place), "users": ["user1"], "netem": False, "people": False}
    return usual | parameters


def recorder(place, **parameters):
    return NodeProcess(MODULE, values(place, **parameters))


def recorded(folder):
    salvage = Salvage()
    return list(messages((folder / "session.mcap").open("rb"), salvage)), salvage


def test_everything_published_is_recorded_in_the_order_of_reception(tmp_path):
    folder = tmp_path / "a"
    with ros() as peer, recorder(folder) as process:
        session = Session(peer)
        process.await_output("^ready$")
        session.send(200)
        session.in_file(folder, 400)
        assert process.stop() == 0
        assert process.output == "ready"
    found, salvage = recorded(folder)
    assert sorted(message.topic for message in found) == [DOWN] * 200 + [UP] * 200
    assert [message.log_ns for message in found] == sorted(m.log_ns for m in found)
    assert salvage.metadata["session"] == {"source": "live"}
    assert salvage.whole
    traces = read_session(folder)
    assert traces.packets[UP].seq.tolist() == list(range(1, 201))
    assert traces.counts["/server/trace"] == {"messages": 0, "missing": 0}


def test_it_is_not_ready_before_every_topic_has_a_publisher_and_what_is_missing_is_known(tmp_path):
    with ros() as peer, recorder(tmp_path / "a") as process:
        publisher = peer.publisher(Wave, record_of(UP), reliable=True)
        peer.until(publisher.get_subscription_count)
        assert process.lines == []
        session = Session(peer)
        process.await_output("^ready$")
        session.send(20, skip=(7, 8, 12))
        session.in_file(tmp_path / "a", 34)
        assert process.stop(signal.SIGTERM) == 0
    assert read_session(tmp_path / "a").counts[UP] == {"messages": 17, "missing": 3}


def test_a_killed_recorder_leaves_what_it_flushed(tmp_path):
    folder = tmp_path / "a"
    with ros() as peer, recorder(folder) as process:
        session = Session(peer)
        process.await_output("^ready$")
        session.send(100)
        session.in_file(folder, 200)
        assert process.stop(signal.SIGKILL) == -signal.SIGKILL
    found, salvage = recorded(folder)
    assert len(found) == 200
    assert salvage.end is not None
    assert any("ends early" in event["what"] for event in read_session(folder).events)


def test_a_disk_too_full_to_begin_is_refused_in_one_line(tmp_path):
    with recorder(tmp_path / "a", reserve_mib=2**40) as process:
        assert process.wait() == 2
        assert "are kept free; make room or choose another folder" in process.output
        assert len(process.lines) == 1


def test_a_full_disk_is_reported_at_once_and_the_recorder_stays(tmp_path):
    folder = tmp_path / "a"
    with ros() as peer, recorder(folder) as process:
        session = Session(peer)
        process.await_output("^ready$")
        session.send(10)
        session.in_file(folder, 20)
        room = (folder / "session.mcap").stat().st_size + 10
        resource.prlimit(process.process.pid, resource.RLIMIT_FSIZE, (room, room))
        session.send(300)
        process.await_output("recording stopped: .*kept up to the last full second")
        assert process.process.poll() is None
        assert process.stop() == 0
    assert len(recorded(folder)[0]) == 20


def test_a_recording_is_never_overwritten(tmp_path):
    (tmp_path / "session.mcap").write_bytes(b"something")
    assert "never overwritten" in refused(main, values(tmp_path))
    assert (tmp_path / "session.mcap").read_bytes() == b"something"
