# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Access to a session, with real nodes: forged packets beside a session, and the policy of SROS2
beside the topics and services that the nodes really have.
"""

import contextlib
from contextlib import ExitStack

import pytest
from support.processes import NodeProcess, ros

from pmwvc_bringup.session.policy import accesses
from pmwvc_core.params import OperatorParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.messages.wire import packet_of, wave_bytes
from pmwvc_core.runtime.polling import RECORDED_QOS, WAVE_QOS
from pmwvc_core.runtime.token_files import write_session
from pmwvc_core.transport.admission import Admission
from pmwvc_core.transport.token import Token
from pmwvc_msgs.msg import MasterTrace, Reception, ServerTrace, Wave

pytestmark = pytest.mark.integration
NODES = {"server": "/", "netem": "/", "recorder": "/", "master": "/user1"}
SILENT = ("server silent", "server receives nothing")
NOT_ALWAYS = {  # of a device that speaks ROS, and of a hand from outside
    "/user1/device/servo_cf",
    "/user1/device/measured_cp",
    "/user1/device/measured_cv",
    "/user1/hand/target",
    "/user1/hand/held",
}


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """Four nodes with tokens, and a peer without one."""
    folder = tmp_path_factory.mktemp("security")
    write_session(folder / "keys", ["user1"])
    users = {"users": ["user1"]}
    with ExitStack() as stack:
        peer = stack.enter_context(ros())
        for module, values, arguments in (
            ("pmwvc_analysis.recorder_node", {**users, "folder": str(folder / "session")}, ()),
            ("pmwvc_netem.node", users, ()),
            (
                "pmwvc_server.node",
                {**users, "session.token_file": str(folder / "keys" / "server")},
                (),
            ),
            (
                "pmwvc_master.node",
                {
                    "session.token_file": str(folder / "keys" / "user1"),
                    "operator": OperatorParams(kind="none"),
                },
                ("-r", "__ns:=/user1"),
            ),
        ):
            node = stack.enter_context(NodeProcess(module, values, arguments=arguments))
        blocks = peer.collect(MasterTrace, "/user1/trace")
        peer.until(lambda: blocks and blocks[-1].state == MasterTrace.COUPLED)
        yield peer, blocks, node


def differences(node):
    """Return what nodes have and the policy lacks, and the other way round, as texts."""
    policy = {access.node: access for access in accesses(["user1"])}
    found = []
    for name, namespace in NODES.items():
        rights = policy[name]
        assert rights.namespace == namespace
        if (name, namespace) not in node.get_node_names_and_namespaces():
            return [f"{name} is not known yet"]
        for what, names, allowed in (
            ("publishes", node.get_publisher_names_and_types_by_node, rights.publishes),
            ("subscribes", node.get_subscriber_names_and_types_by_node, rights.subscribes),
            ("replies", node.get_service_names_and_types_by_node, rights.replies),
            ("requests", node.get_client_names_and_types_by_node, rights.requests),
        ):
            has = {topic for topic, _ in names(name, namespace)}
            found += [f"{name} {what} {topic}: not allowed" for topic in has - set(allowed)]
            unused = set(allowed) - has - NOT_ALWAYS
            found += [f"{name} {what} {topic}: it does not" for topic in unused]
    return found


def test_nodes_have_the_topics_and_services_of_the_policy_and_no_others(session):
    peer, *_ = session
    with contextlib.suppress(AssertionError):  # the difference is more use than a time limit
        peer.until(lambda: not differences(peer.node))
    assert differences(peer.node) == []


def test_forged_packets_are_refused_counted_and_without_effect(session):
    """A program in the session that reads every packet, but has no token."""
    peer, blocks, _ = session
    received = peer.collect(Reception, "/server/reception", reliable=True)
    heard = peer.collect(Wave, "/server/user1/wave_up", raw=True)
    out = peer.node.create_publisher(Wave, "/server/user1/wave_up", WAVE_QOS)
    peer.until(lambda: out.get_subscription_count() >= 1 and heard and received)
    peer.until(lambda: blocks and blocks[-1].state == MasterTrace.COUPLED)
    true = packet_of(heard[-1])
    stranger = Admission(Token(true.session, "user1", bytes(32)), out="up", into="down")
    other = Admission(Token(1, "user1", bytes(32)), out="up", into="down")
    before = len(blocks)
    begin = received[-1]
    own, seen = set(), len(heard)

    def counted(name):
        return getattr(received[-1], name) - getattr(begin, name)

    def attack():
        """Answer each true packet with a forged one of each kind: no flood."""
        nonlocal seen
        true_ones = [data for data in heard[seen:] if bytes(data) not in own]
        seen = len(heard)
        for _ in true_ones:
            true.seq += 1000
            true.wave = 5.0
            data = wave_bytes(true, 0)
            sealed = stranger.sealed(data)  # knows epoch, session and number
            for forged in (sealed, other.sealed(data), bytes(data[:60])):
                own.add(forged)
                out.publish(forged)
        counts = [counted(name) for name in ("forged", "other_session", "malformed", "accepted")]
        return min(counts) > 5 and blocks[-1].state == MasterTrace.COUPLED

    peer.until(attack)
    assert counted("stranger") == 0
    for block in blocks[before:]:
        # A machine that stands still for 50 ms makes either end silent, with or without forgers.
        assert block.state == MasterTrace.COUPLED or block.reason.startswith(SILENT)
        assert max(map(abs, block.f_applied)) < 1e-6  # nobody presses
    assert messages.nanoseconds(received[-1].stamp) > messages.nanoseconds(begin.stamp)


def test_packets_played_back_in_an_outage_or_after_a_goodbye_bring_nobody_back(session):
    """A program without a token that sends true packets again, as they were."""
    peer, _, master = session
    heard, steps = peer.collect(Wave, "/server/user1/wave_up", raw=True), []
    peer.node.create_subscription(ServerTrace, "/server/trace", steps.append, RECORDED_QOS)
    received = peer.collect(Reception, "/server/reception", reliable=True)
    out = peer.node.create_publisher(Wave, "/server/user1/wave_up", WAVE_QOS)
    peer.until(lambda: out.get_subscription_count() >= 1 and len(heard) > 400)
    old = [bytes(data) for data in heard[:40]]

    def in_state(state):
        peer.until(lambda: steps[-1].state[0] == state)

    def after(reports):
        seen = len(received)
        peer.until(lambda: len(received) >= seen + reports)
        return received[-1]

    def played_back():
        """Play them back, one a step; return the states of the steps."""
        first = len(steps)
        for data in old:
            seen = len(steps)
            out.publish(data)
            peer.until(lambda seen=seen: len(steps) > seen)
        return {step.state[0] for step in steps[first:]}

    assert peer.set_parameters("/netem", {"user1.link.up.loss": 1.0}) == [""]
    in_state(ServerTrace.DAMPING)
    before = after(2)
    assert played_back() == {ServerTrace.DAMPING}
    later = after(2)
    assert later.accepted == before.accepted
    assert later.reordered + later.duplicate >= before.reordered + before.duplicate + 40
    assert peer.set_parameters("/netem", {"user1.link.up.loss": 0.0}) == [""]
    in_state(ServerTrace.COUPLED)
    assert after(2).accepted > later.accepted
    assert master.stop() == 0
    in_state(ServerTrace.ABSENT)
    before = after(2)
    assert played_back() == {ServerTrace.ABSENT}
    assert after(2).accepted == before.accepted
