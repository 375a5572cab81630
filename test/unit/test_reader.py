# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Session folders being read."""

import dataclasses
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
from support.plain import load
from support.rewriting import raw, rewritten
from support.simulated import simulated

from pmwvc_analysis.events.events import complete
from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_analysis.recording.topics import Topic
from pmwvc_analysis.recording.writer import SessionWriter
from pmwvc_analysis.traces.holes import holes
from pmwvc_analysis.verdicts.endings import shortened
from pmwvc_core.errors import RecordingError, ScenarioError


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A recording of one second."""
    place = tmp_path_factory.mktemp("session")
    traces = handmade.session(duration_s=1.0)
    record_traces(place, traces, handmade.scenario(duration_s=1.0), start_ns=START_NS)
    return place


def same(left, right, what=""):
    """Compare traces field by field."""
    if dataclasses.is_dataclass(left):
        for field in dataclasses.fields(left):
            same(getattr(left, field.name), getattr(right, field.name), f"{what}.{field.name}")
    elif isinstance(left, dict):
        assert left.keys() == right.keys(), what
        for key in left:
            same(left[key], right[key], f"{what}[{key}]")
    elif isinstance(left, list):
        assert len(left) == len(right), what
        for place, (a, b) in enumerate(zip(left, right, strict=True)):
            same(a, b, f"{what}[{place}]")
    elif isinstance(left, np.ndarray):
        tolerance = 2e-9 if what.endswith("time_s") else 1e-15
        np.testing.assert_allclose(left, right, atol=tolerance, rtol=0, err_msg=what)
        assert left.dtype == right.dtype, what
    elif isinstance(left, float):
        assert left == pytest.approx(right, abs=1e-9), what
    else:
        assert left == right, what


@pytest.mark.parametrize("dof", [1, 3])
def test_what_was_recorded_comes_back(tmp_path, dof):
    traces = handmade.session(duration_s=0.8, dof=dof)
    record_traces(tmp_path, traces, handmade.scenario(duration_s=0.8, dof=dof), start_ns=START_NS)
    found = read_session(tmp_path)
    assert found.source == "simulated"
    assert found.events == []
    same(traces.users, found.users, "users")
    same(traces.server, found.server, "server")
    same(traces.packets, found.packets, "packets")
    same(traces.fates, found.fates, "fates")
    assert set(found.link_states) == set(traces.fates)
    assert found.duration_s == pytest.approx(traces.duration_s)
    assert all(count["missing"] == 0 for count in found.counts.values())


def test_a_state_of_a_link_has_the_delays_of_the_last_second(tmp_path):
    scenario = load("wall", settings_texts=["changes=1.2 link.delay_s=0.05"], duration_s=3.2)
    traces = simulated(scenario)
    record_traces(tmp_path, traces, scenario, start_ns=START_NS)
    found, fates = read_session(tmp_path).link_states["user1/up"], traces.fates["user1/up"]
    delays_s = 1e-9 * (fates.time_out_ns - fates.time_in_ns)
    for second, (least_s, most_s) in enumerate(
        zip(found["delay_min"], found["delay_max"], strict=True)
    ):
        out = (fates.time_out_ns >= second * 1e9) & (fates.time_out_ns < (second + 1) * 1e9)
        assert (least_s, most_s) == pytest.approx((delays_s[out].min(), delays_s[out].max()))
    assert found["delay_max"][0] < 0.04 < found["delay_min"][2]


def test_a_damaged_scenario_is_refused_with_its_path_and_place(tmp_path):
    (tmp_path / "scenario.yaml").write_text("users: [\n")
    with pytest.raises(ScenarioError, match=r"scenario\.yaml: is not YAML in line 2, column 1"):
        read_scenario(tmp_path)


def test_the_scenario_comes_back(folder, tmp_path):
    assert read_scenario(folder) == handmade.scenario(duration_s=1.0)
    assert read_scenario(tmp_path) is None


def test_a_recording_from_before_there_were_channels_is_one_of_the_plain_channel(folder, tmp_path):
    known = yaml.safe_load((folder / "scenario.yaml").read_text("utf-8"))
    del known["channel"]
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(known), "utf-8")
    assert read_scenario(tmp_path).channel == "plain"
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(known | {"channel": "strict"}), "utf-8")
    assert read_scenario(tmp_path).channel == "strict"


@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_a_folder_that_another_tool_recorded_is_read(folder, tmp_path, plugin):
    store, place = schemas.typestore(), tmp_path / "bag"
    with Ros2Writer(place, version=9, storage_plugin=plugin) as writer:
        topics = {}
        for message in raw(folder):
            if message.topic not in topics:
                topics[message.topic] = writer.add_connection(
                    message.topic, message.type_name, typestore=store
                )
            writer.write(topics[message.topic], message.log_ns, message.data)
    ours, theirs = read_session(folder), read_session(place)
    same(ours.users, theirs.users, "users")
    same(ours.server, theirs.server, "server")
    same(ours.packets, theirs.packets, "packets")
    assert theirs.source == "live"


def test_a_file_without_its_end_is_read_as_far_as_it_is_whole(folder, tmp_path):
    with (folder / "session.mcap").open("rb") as stream:
        last = make_reader(stream).get_summary().chunk_indexes[-1]
        stream.seek(0)
        data = stream.read(last.chunk_start_offset + last.chunk_length // 2)
    (tmp_path / "session.mcap").write_bytes(data)
    found = read_session(tmp_path)
    (event,) = [event for event in found.events if event["who"] == "recorder"]
    assert "ends early" in event["what"]
    found.source = "live"  # of which the scenario's length is expected
    on_record = shortened(found, handmade.scenario(duration_s=30.0))
    assert on_record == f"{event['what']}: {found.duration_s:.1f} of 30 s are on record"
    found.events.clear()
    assert shortened(found, handmade.scenario(duration_s=30.0)).startswith("the session ended")
    found.source = "simulated"
    assert 0 < len(found.users[0].tick) < 1000
    assert found.source == "simulated"


@pytest.mark.parametrize("left_out", ["/server/trace", "/user1/trace", "/netem/fates"])
def test_a_topic_that_is_not_there_leaves_its_part_empty(folder, tmp_path, left_out):
    kept = [message for message in raw(folder) if message.topic != left_out]
    found = read_session(rewritten(kept, tmp_path / "b"))
    assert (found.server is None) == (left_out == "/server/trace")
    assert len(found.users) == 2 - (left_out == "/user1/trace")
    assert (found.fates == {}) == (left_out == "/netem/fates")


def test_a_hand_that_is_not_known_is_not_a_number(folder, tmp_path):
    def unknown(topic, message):
        if topic == "/user1/trace":
            message.hand_force_known, message.f_h = False, np.zeros(0)
        return message

    found = read_session(rewritten(raw(folder), tmp_path / "b", unknown))
    assert np.isnan(found.users[0].f_h).all()
    assert np.isfinite(found.users[1].f_h).all()


def test_energies_go_on_when_a_master_starts_again(folder, tmp_path):
    half = 100  # blocks, while the force rises

    def restarted(topic, message):
        if topic == "/user1/trace" and message.seq > half:
            message.epoch, message.seq = message.epoch + 1, message.seq - half
            message.first_tick -= half * TICKS
            message.energy_u_m -= restarted.before
        elif topic == "/user1/trace":
            restarted.before = message.energy_u_m
        elif topic.endswith("/user1/wave_up") and message.seq > half:
            message.epoch += 1
        return message

    before, after = (
        read_session(place)
        for place in (folder, rewritten(raw(folder), tmp_path / "b", restarted))
    )
    same(before.users[0].energy["u_m"], after.users[0].energy["u_m"], "u_m")
    again = [event for event in complete(after, None) if event["kind"] == "restart"]
    assert [(event["who"], event["time_s"]) for event in again] == [("user1 master", 0.8)]
    assert not [event for event in complete(before, None) if event["kind"] == "restart"]


def test_blocks_that_are_missing_are_holes_and_no_fault_of_the_master(folder, tmp_path):
    def holed(topic, message):
        gone = topic == "/user1/trace" and 30 < message.seq <= 40
        return None if gone else message

    found = read_session(rewritten(raw(folder), tmp_path / "b", holed))
    (hole,) = holes(found)
    assert (hole.owner, hole.missing) == ("user1", 10)
    assert (hole.start_s, hole.end_s) == pytest.approx((0.24, 0.32))
    (event,) = [each for each in complete(found, None) if each["kind"] in ("recording", "stall")]
    assert event["who"] == "recorder"
    assert found.counts["/user1/trace"]["missing"] == 10


def test_a_master_that_stood_still_is_no_other_publisher(folder, tmp_path):
    """The block under way is recorded two seconds late; all later ones begin as much later."""
    block, still_ns = 60, 2_000_000_000

    def stood_still(topic, message):
        if topic == "/user1/trace" and message.seq > block:
            message.start_ns += still_ns
            message.stamp.sec += 2
        return message

    changed, count = [], 0
    for each in raw(folder):
        count += each.topic == "/user1/trace"
        late = each.topic == "/user1/trace" and count >= block
        changed.append(each._replace(log_ns=each.log_ns + still_ns) if late else each)
    found = read_session(rewritten(changed, tmp_path / "b", stood_still))
    assert not [each for each in found.events if each.get("kind") == "stranger"]
    assert not holes(found)
    stalls = [e["what"] for e in complete(found, None) if e["kind"] == "stall"]
    assert stalls == ["no ticks for 2.000 s: the loop did not run"]


def test_a_block_recorded_before_it_ran_is_left_out(folder, tmp_path):
    """The control: in number and clock between its neighbours, recorded two seconds early."""
    changed, count = [], 0
    for each in raw(folder):
        count += each.topic == "/user1/trace"
        early = each.topic == "/user1/trace" and count == 60
        changed.append(each._replace(log_ns=each.log_ns - 2_000_000_000) if early else each)
    found = read_session(rewritten(changed, tmp_path / "b"))
    (event,) = [each for each in found.events if each.get("kind") == "stranger"]
    assert event["what"] == "1 message on /user1/trace out of sequence, left out"


def test_a_wave_that_was_not_recorded_is_missing(folder, tmp_path):
    def without(topic, message):
        return None if topic == "/user1/wave_up" and message.seq in (5, 6) else message

    counts = read_session(rewritten(raw(folder), tmp_path / "b", without)).counts
    assert counts["/user1/wave_up"] == {"messages": 123, "missing": 2}


def test_what_a_link_lost_is_not_missing_but_what_it_delivered_is(folder, tmp_path):
    def lossy(topic, message):
        if topic == "/netem/fates" and message.link == "user1/up" and message.first == 1:
            message.fate, message.time_out_ns = message.fate.copy(), message.time_out_ns.copy()
            message.fate[9], message.time_out_ns[9] = 1, 0  # packet 10 lost by the link
        gone = topic == "/server/user1/wave_up" and message.seq in (10, 20)
        return None if gone else message

    counts = read_session(rewritten(raw(folder), tmp_path / "b", lossy)).counts
    assert counts["/server/user1/wave_up"]["missing"] == 1


def test_fates_that_were_not_recorded_are_not_taken_for_packets_that_never_came(folder, tmp_path):
    def without(topic, message):
        gone = topic == "/netem/fates" and message.link == "user1/up" and message.first == 1
        return None if gone else message

    found = read_session(rewritten(raw(folder), tmp_path / "b", without))
    assert found.counts["/netem/fates"]["missing"] > 0
    assert "not_relayed" not in found.counts["/user1/wave_up"]


def test_a_message_that_is_none_is_passed_over_and_reported(folder, tmp_path):
    with SessionWriter(tmp_path / "b") as writer:
        for message in raw(folder):
            writer.add_topic(Topic(message.topic, message.type_name, True, 10))
            writer.write(message.topic, message.data, log_ns=message.log_ns)
        writer.write("/user1/wave_up", b"\0\1\0\0garbage", log_ns=START_NS + 10**9)
    found = read_session(tmp_path / "b")
    assert len(found.packets["/user1/wave_up"].seq) == 125
    assert any("cannot be decoded" in event["what"] for event in found.events)


def test_what_the_runner_noted_is_on_the_time_line_of_the_session(folder, tmp_path):
    place = rewritten(raw(folder), tmp_path / "b")
    noted = [{"time_ns": START_NS + 250_000_000, "who": "server", "what": "killed"}]
    (place / "events.json").write_text(json.dumps(noted))
    (event,) = read_session(place).events
    assert event["time_s"] == pytest.approx(0.25)
    assert event["who"] == "server"


def test_a_file_that_is_no_mcap_is_refused(tmp_path):
    file = tmp_path / "notes.txt"
    file.write_text("no recording")
    with pytest.raises(RecordingError, match=r"notes\.txt is not an MCAP file.*name a session"):
        read_session(file)
    (tmp_path / "session.mcap").write_bytes(b"")
    with pytest.raises(RecordingError, match=r"session\.mcap is empty; name a session folder"):
        read_session(tmp_path)


def test_an_empty_folder_is_answered_with_what_to_name_instead(tmp_path):
    with pytest.raises(RecordingError, match=r"holds no recording.*name a session folder"):
        read_session(tmp_path)


def test_a_recording_of_something_else_is_answered_with_its_topics(tmp_path):
    store = get_typestore(Stores.ROS2_JAZZY)
    kind = "std_msgs/msg/String"
    with Ros2Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/chat", kind, typestore=store)
        data = store.serialize_cdr(store.types[kind](data="x"), kind)
        writer.write(connection, 10**18, data)
    with pytest.raises(RecordingError, match=r"it has /chat; a session has /server/trace"):
        read_session(tmp_path / "bag")


@pytest.mark.parametrize("what", ["nothing", "no messages", "no such folder"])
def test_what_holds_no_session_is_refused_in_words(tmp_path, what):
    place = tmp_path / "a"
    if what != "no such folder":
        place.mkdir()
    if what == "no messages":
        SessionWriter(place).close()
    with pytest.raises(RecordingError, match=str(place)):
        read_session(place)
