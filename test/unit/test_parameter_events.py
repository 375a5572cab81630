# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that changed during a session are events of it."""

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from support import handmade
from support.handmade import START_NS

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.parameter_events import MOST_EVENTS, parameter_change, taken_over
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.recording.salvage import Salvage, messages
from pmwvc_analysis.recording.topics import Topic
from pmwvc_analysis.recording.writer import SessionWriter

TOPIC = Topic("/parameter_events", schemas.PARAMETER_EVENT, True, 1000, essential=False)


def change(at_s, node, **values):
    """Make an event in which parameters changed; ``__`` stands for a dot."""
    at_ns = START_NS + round(at_s * 1e9)
    message = ParameterEvent(node=node)
    message.stamp.sec, message.stamp.nanosec = divmod(at_ns, 10**9)
    message.changed_parameters = [
        Parameter(name.replace("__", "."), value=value).to_parameter_msg()
        for name, value in values.items()
    ]
    return at_ns, serialize_message(message)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    place = tmp_path_factory.mktemp("plain")
    record_traces(
        place,
        handmade.session(duration_s=1.0),
        handmade.scenario(duration_s=1.0),
        start_ns=START_NS,
    )
    return place


def events_of(recorded, folder, *changes, junk=b""):
    """Return the parameter events of a session in which these changes were recorded."""
    nodes = folder / "nodes"
    nodes.mkdir()
    given = {"safety": {"max_force": 8.0}, "master": {"impedance": 25.0}}
    for name, values in (("user1", given), ("netem", {"user1": {"link": {"up": {"loss": 0.0}}}})):
        text = yaml.safe_dump({"/**": {"ros__parameters": values}})
        (nodes / f"{name}.yaml").write_text(text, "utf-8")
    with SessionWriter(folder) as writer:
        for message in messages(recorded / "session.mcap", Salvage()):
            writer.add_topic(Topic(message.topic, message.type_name, True, 10))
            writer.write(message.topic, message.data, log_ns=message.log_ns)
        writer.add_topic(TOPIC)
        for at_ns, data in changes:
            writer.write(TOPIC.name, data, log_ns=at_ns)
        if junk:
            writer.write(TOPIC.name, junk, log_ns=START_NS)
    traces = read_session(folder)
    return [event for event in traces.events if event.get("kind") == "parameter"]


def test_a_change_is_recorded_with_time_node_old_and_new_value(recorded, tmp_path):
    (event,) = events_of(recorded, tmp_path, change(0.5, "/user1/master", safety__max_force=4.0))
    assert event["time_s"] == pytest.approx(0.5, abs=1e-6)
    assert event["who"] == "user1 master"
    assert event["what"] == "safety.max_force set to 4 N (was 8 N)"


def test_changes_have_the_names_of_a_scenario(recorded, tmp_path):
    events_of(
        recorded,
        tmp_path,
        change(0.2, "/lab/user1/master", safety__max_force=4.0),
        change(0.3, "/server", user1__server__contact_stiffness=900.0, server__impedance=0.0),
        change(0.4, "/server", qos=3),
        change(0.5, "/user1/other", safety__max_force=2.0),
    )
    found = read_session(tmp_path).settings
    assert [round(time_s, 6) for time_s, _ in found] == [0.2, 0.3]
    assert found[0][1] == {"user1.safety.max_force": 4.0}
    assert found[1][1] == {"user1.server.contact_stiffness": 900.0, "server.impedance": None}


def test_a_change_counts_from_the_step_or_the_frame_that_took_it_over(recorded):
    traces = read_session(recorded)
    server, user = traces.server, traces.users[0]
    server.changes = (server.step >= 40).astype(int)
    block = user.changes.size // 2
    user.changes = (np.arange(user.changes.size) >= block).astype(int)
    step_s, tick_s = server.time_s[39], user.time_s[user.block_rows[block]]
    settings = [
        (step_s - 0.02, {"user1.server.contact_damping": 9.0}),
        (tick_s - 0.02, {"user1.safety.max_force": 4.0}),
        (0.5, {"user1.link.up.delay_s": 0.01}),
    ]
    found = taken_over(settings, traces.users, server)
    assert sorted(time_s for time_s, _ in found) == pytest.approx(
        sorted([step_s - 5e-4, tick_s - 5e-4, 0.5])
    )


def test_a_change_of_a_link_does_not_wait_for_the_next_one_of_the_server(recorded):
    traces = read_session(recorded)
    server = traces.server
    server.changes = (server.step >= 40).astype(int)
    early_s = server.time_s[39] - 0.02
    settings = [(early_s, {"user1.link.up.delay_s": 0.01})]
    assert taken_over(settings, traces.users, server) == settings


def test_the_value_before_is_that_of_the_last_change(recorded, tmp_path):
    found = events_of(
        recorded,
        tmp_path,
        change(0.2, "/user1/master", master__impedance=30.0, safety__max_force=8.0),
        change(0.4, "/user1/master", master__impedance=10.0),
    )
    assert [event["what"] for event in found] == [
        "master.impedance set to 30 N s/m (was 25 N s/m)",
        "master.impedance set to 10 N s/m (was 30 N s/m)",
    ]


def test_links_text_and_lists_of_changes_are_given_in_one_line(recorded, tmp_path):
    values = {f"user1__link__up__{name}": 0.25 for name in ("loss", "delay_s", "jitter_s")}
    found = events_of(
        recorded,
        tmp_path,
        change(0.2, "/netem", **values, user1__link__up__jitter="normal", user1__link__up__x=1),
    )
    assert [event["what"] for event in found] == [
        "user1.link.up.loss set to 0.25 (was 0), user1.link.up.delay_s set to 0.25 s, "
        "user1.link.up.jitter_s set to 0.25 s, user1.link.up.jitter set to normal and 1 more"
    ]


def test_before_the_session_only_what_differs_from_the_files_counts(recorded, tmp_path):
    found = events_of(
        recorded,
        tmp_path,
        change(-0.5, "/user1/master", safety__max_force=0.5),  # the device allows no more
        change(-0.4, "/netem", link__up__delay_s=0.016),
    )
    assert [event["what"] for event in found] == ["safety.max_force set to 0.5 N (was 8 N)"]


def test_other_programs_and_messages_that_are_none_do_not_matter(recorded, tmp_path):
    stranger = change(0.3, "/rviz", background=1)
    assert events_of(recorded, tmp_path, stranger, junk=b"\x00\x01\x00\x00\xff\xff") == []


def test_a_flood_of_changes_is_cut_and_counted(recorded, tmp_path):
    flood = [
        change(0.001 * n, "/user1/master", master__impedance=30.0 + n)
        for n in range(MOST_EVENTS + 7)
    ]
    found = events_of(recorded, tmp_path, *flood)
    assert len(found) == MOST_EVENTS + 1
    assert found[-1]["what"] == "7 more changes of parameters"


@pytest.mark.parametrize("value", [True, -7, 2.5, "words", [1, 2], [0.5], ["a", "bc"], [True], []])
def test_every_kind_of_value_is_read_as_ros_writes_it(value):
    first, last = {"long_name_of_it": value}, {"x": 1.0}
    change_ = parameter_change(change(0.0, "/a/master", **first, **last)[1])
    expected = "a list" if isinstance(value, list) else value
    assert change_.values == {"long_name_of_it": expected, "x": 1.0}
    assert (change_.node, change_.at_ns) == ("/a/master", START_NS)


@given(st.binary(max_size=200))
def test_bytes_that_are_no_event_are_none_or_harmless(data):
    found = parameter_change(data)
    assert found is None or isinstance(found.values, dict)
