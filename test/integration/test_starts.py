# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The start of a live session: nobody speaks before every end has matched its others."""

import json

import numpy as np
import pytest
from std_srvs.srv import Trigger
from support.processes import NodeProcess, ros
from support.sessions import Running

from pmwvc_analysis.recording.reader import read_session
from pmwvc_core.runtime.matched import PUBLISHERS, SUBSCRIPTIONS, unmatched
from pmwvc_msgs.msg import Wave

pytestmark = pytest.mark.integration
UP, BEHIND = "/user1/wave_up", "/server/user1/wave_up"


def test_a_node_that_waits_states_what_it_has_matched():
    with (
        ros() as peer,
        NodeProcess("pmwvc_netem.node", {"users": ["user1"], "start.paused": True}),
    ):

        def said():
            return json.loads(peer.call(Trigger, "/netem/matched", Trigger.Request()).message)

        before = said()
        assert (before[SUBSCRIPTIONS][UP], before[PUBLISHERS][BEHIND]) == (0, 0)
        ends = {UP: (1, 1), BEHIND: (1, 1)}
        assert unmatched(before, ends) == [
            f"{BEHIND}: 0 of 1 subscribers matched",
            f"{UP}: 0 of 1 publishers matched",
        ]
        publisher = peer.publisher(Wave, UP)
        peer.subscribe(Wave, BEHIND, lambda _: None)
        peer.until(publisher.get_subscription_count)
        peer.until(lambda: unmatched(said(), ends) == [])


@pytest.fixture(params=["session of 4 s", 1, 2])
def folder(request, tmp_path):
    """Three sessions that have begun; one of them others read as well."""
    if isinstance(request.param, str):
        return request.getfixturevalue("carried").folder
    with Running(tmp_path / "session", "carry_16ms", "--duration", 1) as session:
        assert session.end() == 0, session.output()
    return session.folder


def test_first_packet_of_every_end_arrives(folder):
    traces = read_session(folder)
    assert not any("not_relayed" in count for count in traces.counts.values())
    assert set(traces.fates) == {f"user{n}/{way}" for n in (1, 2) for way in ("up", "down")}
    for link, fates in traces.fates.items():
        numbers = np.unique(fates.seq)
        assert numbers.tolist() == list(range(1, len(numbers) + 1)), link
    for topic, packets in traces.packets.items():
        assert packets.seq[0] == 1, topic
    assert traces.server.step[0] == 1
