# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reports of a node about its publishers."""

import dataclasses

import pytest
from support.packer import Packer

from pmwvc_core.runtime.watch import Peers
from pmwvc_core.transport.packet import Receipt, refused
from pmwvc_core.transport.receiver import Receiver

DOWN, UP = "/user1/wave_down", "/user1/wave_up"


class Rig:
    def __init__(self, *publishers):
        self.names = {DOWN: list(publishers), UP: ["/user1/master"]}
        self.inbox = Receiver(1, period_s=0.008, timeout_s=0.03)
        self.now_s, self.warnings = 100.0, []
        self.peers = Peers(
            lambda topic: self.names[topic],
            inboxes={DOWN: self.inbox},
            own=[UP],
            warn=self.warnings.append,
            clock=lambda: self.now_s,
        )

    def wrong(self):
        return "; ".join(self.peers.look()[0])


def test_node_without_packets_warns_after_three_seconds(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "17")
    rig = Rig()
    assert rig.wrong() == ""
    rig.now_s += 3.0
    assert rig.wrong().startswith(f"no packets on {DOWN}: no publisher in ROS domain 17")


def test_packets_that_are_all_refused_are_reported_with_the_reason():
    rig = Rig("/netem")
    rig.inbox.push(Packer(1, period=0.02).pack(0.0, 0.0, 0), 0)
    rig.now_s += 3.0
    assert rig.wrong() == f"every packet on {DOWN} was refused: 1 wrong period"


@pytest.mark.parametrize(
    ("topic", "names"), [(DOWN, ["/netem", "/stranger"]), (UP, ["/user1/master"] * 2)]
)
def test_a_second_publisher_is_named_though_packets_come(topic, names):
    rig = Rig("/netem")
    rig.names[topic] = names
    rig.inbox.push(Packer(1, period=0.008).pack(0.0, 0.0, 0), 0)
    assert rig.wrong() == f"2 publishers on {topic}: {', '.join(names)}"


def test_packets_of_another_sender_are_reported_once_and_stay_in_the_values():
    rig = Rig("/netem")
    packet = Packer(0xABC, period=0.008).pack(0.0, 0.0, 0)
    rig.inbox.push(packet, 0)
    rig.inbox.push(dataclasses.replace(packet, epoch=0xDEF), 1)
    wrong, values = rig.peers.look()
    assert wrong == [f"{DOWN}: 1 packet of another sender refused"]
    assert values[f"{DOWN}: sender followed"].endswith("abc")
    assert values[f"{DOWN}: other senders"] == f"{0xDEF:016x} (1 packets)"
    assert rig.wrong() == ""


@pytest.mark.parametrize(
    ("verdict", "text"),
    [
        (
            Receipt.FORGED,
            "2 packets refused: the user's token (session.token_file) did not seal them",
        ),
        (
            Receipt.OTHER_SESSION,
            "2 packets of another session refused: session.token_file must be of one "
            "'pmwvc token' at both ends, or empty at both",
        ),
        (Receipt.FLOOD, "2 packets beyond the rate of a sender refused"),
        (Receipt.CORRUPTED, "2 packets corrupted on their way"),
    ],
)
def test_packets_refused_at_the_door_are_reported_once(verdict, text):
    rig = Rig("/netem")
    rig.inbox.push(Packer(1, period=0.008).pack(0.0, 0.0, 0), 0)
    for _ in range(2):
        rig.inbox.push(refused(verdict), 1)
    assert rig.wrong() == f"{DOWN}: {text}"
    assert rig.wrong() == ""


def test_a_wrong_token_is_told_when_it_begins_and_again_after_a_pause():
    rig, told = Rig("/netem", "/stranger"), []  # also where that is another publisher
    for verdict in (Receipt.FORGED, Receipt.FORGED, Receipt.CORRUPTED, Receipt.FORGED):
        rig.inbox.push(refused(verdict), 1)
        rig.wrong()
        told.append(len(rig.warnings))
    assert told == [1, 1, 1, 2]
    text = "1 packet refused: the user's token (session.token_file) did not seal them"
    assert set(rig.warnings) == {f"{DOWN}: {text}"}
