# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Session folders being read: other tools', damaged ones, with gaps, recorded late."""

import json

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore
from support import handmade
from support.handmade import START_NS, TICKS
from support.rewriting import raw, rewritten, unequal, written

from pmwvc_analysis.events.events import complete
from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_analysis.recording.writer import SessionWriter
from pmwvc_analysis.traces.holes import holes
from pmwvc_analysis.verdicts.endings import shortened
from pmwvc_core.errors import RecordingError, ScenarioError

SCENARIO = handmade.scenario(duration_s=1.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A recording of one second."""
    place = tmp_path_factory.mktemp("session")
    traces = handmade.session(duration_s=1.0)
    traces.users[1].safety_events = 3
    record_traces(place, traces, SCENARIO, start_ns=START_NS)
    return place


def test_the_scenario_comes_back_one_from_before_there_were_channels_as_plain(folder, tmp_path):
    assert read_scenario(tmp_path) is None
    assert read_scenario(folder) == SCENARIO
    known = yaml.safe_load((folder / "scenario.yaml").read_text("utf-8"))
    del known["channel"]
    for more, channel in (({}, "plain"), ({"channel": "strict"}, "strict")):
        (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(known | more), "utf-8")
        assert read_scenario(tmp_path).channel == channel
    (tmp_path / "scenario.yaml").write_text("users: [\n")
    with pytest.raises(ScenarioError, match=r"scenario\.yaml: is not YAML in line 2, column 1"):
        read_scenario(tmp_path)


def test_a_folder_that_another_tool_recorded_is_read(folder, tmp_path):
    store, place, topics = schemas.typestore(), tmp_path / "bag", {}
    with Ros2Writer(place, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for topic, kind, log_ns, _, data in raw(folder):
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(topics[topic], log_ns, data)
    ours, theirs = read_session(folder), read_session(place)
    for name in ("users", "server", "packets", "fates"):
        assert list(unequal(getattr(ours, name), getattr(theirs, name))) == []
    assert theirs.source == "live"
    assert [user.safety_events for user in ours.users] == [0, 3]  # interventions of the limits


def test_a_file_without_its_end_is_read_as_far_as_it_is_whole(folder, tmp_path):
    data = (folder / "session.mcap").read_bytes()
    with (folder / "session.mcap").open("rb") as stream:
        last = make_reader(stream).get_summary().chunk_indexes[-1]
    (tmp_path / "session.mcap").write_bytes(
        data[: last.chunk_start_offset + last.chunk_length // 2]
    )
    found, expected = read_session(tmp_path), handmade.scenario(duration_s=30.0)
    assert found.source == "simulated" and 0 < len(found.users[0].tick) < 1000
    (event,) = [event for event in found.events if event["who"] == "recorder"]
    assert "ends early" in event["what"]
    found.source = "live"  # of which the scenario's length is expected
    on_record = shortened(found, expected)
    assert on_record == f"{event['what']}: {found.duration_s:.1f} of 30 s are on record"
    found.events.clear()
    assert shortened(found, expected).startswith("the session ended")


@pytest.mark.parametrize("left_out", ["/server/trace", "/user1/trace", "/netem/fates"])
def test_a_topic_that_is_not_there_leaves_its_part_empty(folder, tmp_path, left_out):
    kept = [message for message in raw(folder) if message.topic != left_out]
    found = read_session(rewritten(kept, tmp_path / "b"))
    assert (found.server is None) == (left_out == "/server/trace")
    assert len(found.users) == 2 - (left_out == "/user1/trace")
    assert (found.fates == {}) == (left_out == "/netem/fates")


def test_energies_go_on_when_a_master_starts_again(folder, tmp_path):
    half, before, place = 100, {}, tmp_path / "b"  # blocks, while the force rises

    def restarted(topic, message):
        if topic == "/user1/trace" and message.seq > half:
            message.epoch, message.seq = message.epoch + 1, message.seq - half
            message.first_tick -= half * TICKS
            message.energy_u_m -= before["energy_u_m"]
        elif topic == "/user1/trace":
            before["energy_u_m"] = message.energy_u_m
        elif topic.endswith("/user1/wave_up") and message.seq > half:
            message.epoch += 1
        return message

    whole, after = (read_session(p) for p in (folder, rewritten(raw(folder), place, restarted)))
    energies = (found.users[0].energy["u_m"] for found in (whole, after))
    np.testing.assert_allclose(*energies, rtol=0.0, atol=1e-15)
    again = [event for event in complete(after, None) if event["kind"] == "restart"]
    assert [(event["who"], event["time_s"]) for event in again] == [("user1 master", 0.808)]
    assert not [event for event in complete(whole, None) if event["kind"] == "restart"]


def test_a_master_that_stood_still_is_no_other_publisher(folder, tmp_path):
    """The block under way is recorded two seconds late; all later ones begin as much later."""
    stood_ns, late, count = 2 * 10**9, [], 0
    for each in raw(folder):
        count += each.topic == "/user1/trace"
        after = each.topic == "/user1/trace" and count >= 60
        late.append(each._replace(log_ns=each.log_ns + stood_ns) if after else each)

    def stood_still(topic, message):
        if topic == "/user1/trace" and message.seq > 60:
            message.start_ns += stood_ns
            message.stamp.sec += 2
        return message

    found = read_session(rewritten(late, tmp_path / "b", stood_still))
    assert not [each for each in found.events if each.get("kind") == "stranger"]
    assert not holes(found)
    stalls = [e["what"] for e in complete(found, None) if e["kind"] == "stall"]
    assert stalls == ["no ticks for 2.000 s: the loop did not run"]


SECOND_NS = 10**9


def never_awake(share, at_ns):
    """The recorder takes everything in when the session is long over."""
    return SECOND_NS + 7 * SECOND_NS // 10, at_ns


def set_back(share, at_ns):
    """The clocks of all that publish were set back in the middle."""
    return at_ns, at_ns - SECOND_NS * (share > 0.5)


def set_on(share, at_ns):
    return at_ns, at_ns + SECOND_NS * (share > 0.5)


def other_host(share, at_ns):
    return at_ns, at_ns - 3600 * SECOND_NS


@pytest.mark.parametrize("recorded", [never_awake, set_back, set_on, other_host])
def test_neither_a_late_recorder_nor_a_clock_that_is_set_changes_a_time(
    folder, tmp_path, recorded
):
    found, changed = raw(folder), []
    first_ns, last_ns = (at(each.log_ns for each in found) for at in (min, max))
    for each in found:
        at_ns = each.log_ns - first_ns
        log_ns, publish_ns = recorded(at_ns / (last_ns - first_ns), at_ns)
        changed.append(each._replace(log_ns=first_ns + log_ns, publish_ns=first_ns + publish_ns))
    before, after = (
        read_session(written(each, tmp_path / name))
        for each, name in ((found, "a"), (changed, "b"))
    )
    assert [each for each in unequal(before, after) if ".rosbag2." not in each] == []


def test_what_was_not_recorded_is_missing_but_not_what_a_link_lost(folder, tmp_path):
    gone = {"/user1/wave_up": (5, 6), "/server/user1/wave_up": (10, 20)}

    def lossy(topic, message):
        if topic != "/netem/fates" or message.first > 1:
            return None if topic in gone and message.seq in gone[topic] else message
        if message.link == "user1/up":
            message.fate, message.time_out_ns = message.fate.copy(), message.time_out_ns.copy()
            message.fate[9], message.time_out_ns[9] = 1, 0  # packet 10 lost by the link
        return None if message.link == "user1/down" else message

    counts = read_session(rewritten(raw(folder), tmp_path / "b", lossy)).counts
    assert counts["/user1/wave_up"] == {"messages": 123, "missing": 2}
    assert counts["/server/user1/wave_up"]["missing"] == 1
    assert counts["/netem/fates"]["missing"] > 0


def test_a_message_that_is_none_is_passed_over_and_what_the_runner_noted_is_in_time(
    folder, tmp_path
):
    found = raw(folder)
    none = found[-1]._replace(topic="/user1/wave_up", data=b"\0\1\0\0garbage")
    written([*found, none], tmp_path / "b")
    noted = [{"time_ns": START_NS + 250_000_000, "who": "server", "what": "killed"}]
    (tmp_path / "b" / "events.json").write_text(json.dumps(noted))
    found = read_session(tmp_path / "b")
    assert len(found.packets["/user1/wave_up"].seq) == 125
    undecoded, killed = found.events
    assert "cannot be decoded" in undecoded["what"]
    assert (killed["who"], killed["time_s"]) == ("server", pytest.approx(0.25))


def chat(place):
    store, kind = get_typestore(Stores.ROS2_JAZZY), "std_msgs/msg/String"
    with Ros2Writer(place, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/chat", kind, typestore=store)
        writer.write(connection, 10**18, store.serialize_cdr(store.types[kind](data="x"), kind))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda place: None, "does not exist"),
        (lambda place: place.write_text("no recording"), "is not an MCAP file.*name a session"),
        (lambda place: place.write_text(""), "is empty; name a session folder"),
        (lambda place: place.mkdir(), "holds no recording.*name a session folder"),
        (lambda place: SessionWriter(place).close(), "holds no message of a session"),
        (chat, "it has /chat; a session has /server/trace"),
    ],
)
def test_what_holds_no_session_is_refused_in_words(tmp_path, make, words):
    make(tmp_path / "a")
    with pytest.raises(RecordingError, match=f"{tmp_path / 'a'}.*{words}"):
        read_session(tmp_path / "a")
