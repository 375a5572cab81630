# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The start of a live session: nobody speaks before every end has matched its others."""

import json

import pytest
from std_srvs.srv import Trigger
from support.processes import NodeProcess, ros
from support.starts import not_heard

from pmwvc_analysis.recording.reader import read_session
from pmwvc_core.runtime.services import PUBLISHERS, SUBSCRIPTIONS, unmatched
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


def test_first_packet_of_every_end_arrives(carried):
    """So it is in the sessions of ``test_controllers``."""
    traces = read_session(carried.folder)
    assert not_heard(traces) == set()
    fates = traces.fates["user2/down"]  # the control: the first packet came too early
    fates.seq = fates.seq[fates.seq > 1]
    assert not_heard(traces) == {"user2/down"}
