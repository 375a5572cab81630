# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Access to a session, with real nodes: forged packets beside a session, and the topics and
services of the guide to SROS2 beside those that the nodes really have.
"""

import contextlib
import re
from contextlib import ExitStack
from pathlib import Path

import pytest
from support.excuses import unless_stalled
from support.peers import ros
from support.processes import NodeProcess

from pmwvc_core.params import OperatorParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.token_files import write_session
from pmwvc_core.runtime.topics import RECORDED_QOS, WAVE_QOS, packet_of, wave_bytes
from pmwvc_core.transport.packet import Admission, Token
from pmwvc_msgs.msg import MasterTrace, Reception, ServerTrace, Wave

pytestmark = pytest.mark.integration
GUIDE = Path(__file__).parents[2] / "docs" / "security.md"
NODES = {"/server": "server", "/netem": "netem", "/recorder": "recorder", "/user1/master": "user1"}
SILENT = ("server silent", "server receives nothing")


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """Four nodes with tokens, and a peer without one."""
    folder = tmp_path_factory.mktemp("security")
    write_session(folder / "keys", ["user1"])
    users = {"users": ["user1"]}
    with ExitStack() as stack:
        peer = stack.enter_context(ros())
        for module, enclave, values, arguments in (
            (
                "pmwvc_analysis.recorder_node",
                "recorder",
                {**users, "folder": str(folder / "session")},
                (),
            ),
            ("pmwvc_netem.node", "netem", users, ()),
            (
                "pmwvc_server.node",
                "server",
                {**users, "session.token_file": str(folder / "keys" / "server")},
                (),
            ),
            (
                "pmwvc_master.node",
                "user1",
                {
                    "session.token_file": str(folder / "keys" / "user1"),
                    "operator": OperatorParams(kind="none"),
                },
                ("-r", "__ns:=/user1"),
            ),
        ):
            words = ("--enclave", f"/pmwvc/{enclave}", *arguments)
            node = stack.enter_context(NodeProcess(module, values, arguments=words))
        blocks = peer.collect(MasterTrace, "/user1/trace")
        peer.until(lambda: blocks and blocks[-1].state == MasterTrace.COUPLED)
        yield peer, blocks, node


def guide():
    """Return what the guide names of each node: topics published, topics subscribed, services."""
    text = GUIDE.read_text("utf-8").partition("## SROS2")[2]
    rows = re.findall(r"^\| (`/[a-z0-9/]+`|every node) \|(.*)\|(.*)\|$", text, re.MULTILINE)
    names = {
        name.strip("`"): tuple(set(re.findall("`(.*?)`", cell)) for cell in cells)
        for name, *cells in rows
    }
    every, of_master = names.pop("every node"), ("rearm", "clutch")
    services = set(re.findall("`~/(.*?)`", text))
    return {
        name: (
            published | every[0],
            subscribed | every[1],
            {f"{name}/{each}" for each in services if each not in of_master or "master" in name},
            set(),
        )
        for name, (published, subscribed) in names.items()
    }


def of_nodes(node):
    """Return what each node has: topics published, subscribed, services replied, requested."""
    found = {}
    for name, namespace, enclave in node.get_node_names_and_namespaces_with_enclaves():
        full = f"{namespace.rstrip('/')}/{name}"
        if full in NODES and enclave == f"/pmwvc/{NODES[full]}":
            found[full] = tuple(
                {topic for topic, _ in names(name, namespace)}
                for names in (
                    node.get_publisher_names_and_types_by_node,
                    node.get_subscriber_names_and_types_by_node,
                    node.get_service_names_and_types_by_node,
                    node.get_client_names_and_types_by_node,
                )
            )
    return found


def test_nodes_have_the_topics_and_services_of_the_guide_and_no_others(session):
    peer, *_ = session
    assert set(guide()) == set(NODES)
    with contextlib.suppress(AssertionError):  # the difference is more use than a time limit
        peer.until(lambda: of_nodes(peer.node) == guide())
    assert of_nodes(peer.node) == guide()


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
        with unless_stalled(lambda reason=block.reason: reason.startswith(SILENT)):
            assert block.state == MasterTrace.COUPLED
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
