# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that changed during a session are events of it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from support import handmade
from support.handmade import START_NS
from support.rewriting import raw, written

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.parameter_events import parameter_change, taken_over
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.recording.salvage import RawMessage


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


def events_of(recorded, folder, *changes):
    """Return the parameter events of a session in which these changes were recorded."""
    topic = "/parameter_events", schemas.PARAMETER_EVENT
    events = [RawMessage(*topic, at_ns, at_ns, data) for at_ns, data in changes]
    written([*raw(recorded), *events], folder)
    return [each for each in read_session(folder).events if each.get("kind") == "parameter"]


def test_changes_are_told_with_time_node_and_value(recorded, tmp_path):
    links = {f"user1__link__up__{name}": 0.25 for name in ("loss", "delay_s", "jitter_s")}
    found = events_of(
        recorded,
        tmp_path,
        change(-0.5, "/user1/master", safety__max_force=0.5),  # the device allows no more
        change(0.2, "/user1/master", master__impedance=30.0),
        change(0.3, "/rviz", background=1),
        change(0.4, "/user1/master", master__impedance=10.0),
        change(0.5, "/netem", **links, user1__link__up__jitter="normal", user1__link__up__x=1),
        (START_NS, b"\x00\x01\x00\x00\xff\xff"),
    )
    assert [(each["who"], each["what"]) for each in found] == [
        ("user1 master", "set safety.max_force=0.5"),
        ("user1 master", "set master.impedance=30.0"),
        ("user1 master", "set master.impedance=10.0"),
        (
            "netem",
            "set user1.link.up.loss=0.25 user1.link.up.delay_s=0.25 "
            "user1.link.up.jitter_s=0.25 user1.link.up.jitter=normal user1.link.up.x=1",
        ),
    ]
    times = [each["time_s"] for each in found]
    assert times == pytest.approx([-0.5, 0.2, 0.4, 0.5], abs=1e-6)


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
    """But not that of a link: it does not wait for the next one of the server."""
    traces = read_session(recorded)
    server, user = traces.server, traces.users[0]
    server.changes = (server.step >= 40).astype(int)
    block = user.changes.size // 2
    user.changes = (np.arange(user.changes.size) >= block).astype(int)
    step_s, tick_s = server.time_s[39], user.time_s[user.block_rows[block]]
    settings = [
        (step_s - 0.02, {"user1.server.contact_damping": 9.0}),
        (tick_s - 0.02, {"user1.safety.max_force": 4.0}),
        (step_s - 0.01, {"user1.link.up.delay_s": 0.01}),
    ]
    found = [time_s for time_s, _ in taken_over(settings, traces.users, server)]
    assert found == pytest.approx(sorted([step_s - 5e-4, tick_s - 5e-4, step_s - 0.01]))


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
