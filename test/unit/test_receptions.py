# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Order, copies, gaps and corruption are counted at the receivers exactly as they were injected,
and the report has them in words; the reports of a node about its publishers.
"""

import dataclasses
from html import unescape
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.packer import Packer
from support.plain import load

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.links import came_out
from pmwvc_analysis.recording.own import Decoded, Series
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.report.report import render
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.runtime.watch import Peers
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import FateTraces, ReceptionTraces
from pmwvc_core.transport.packet import Receipt, refused
from pmwvc_core.transport.receiver import Receiver, counts, passage

FRAME_NS = 8_000_000
OF_LINK = ("accepted", "lost", "duplicate", "reordered", "corrupted")


def fates_of(rows):
    """Return the record of a link that let out (seq, corrupted) in this order."""
    count = len(rows)
    zeros = np.zeros(count, dtype=np.int64)
    return FateTraces(
        link="user1/up",
        number=np.arange(1, count + 1),
        epoch=np.ones(count, dtype=np.uint64),
        seq=np.array([seq for seq, _ in rows], dtype=np.int64),
        size_bytes=zeros,
        time_in_ns=zeros,
        time_due_ns=zeros,
        time_out_ns=1 + np.arange(count),
        fate=zeros + FateKind.DELIVERED,
        cause=np.where([bad for _, bad in rows], Cause.CORRUPTION, Cause.NONE),
    )


def done_by(fates, received):
    """Return what a receiver must have counted of the packets that its link let out."""
    rows = np.flatnonzero(came_out(fates))
    taken = sum(received.counts[name] for name in OF_LINK if name != "lost")
    rows = rows[np.argsort(fates.time_out_ns[rows], kind="stable")]
    rows = rows[:taken]  # the rest was still on its way at the end
    corrupted = fates.cause[rows] == Cause.CORRUPTION
    found = dict.fromkeys(OF_LINK, 0) | {"corrupted": int(corrupted.sum())}
    came = set()
    newest = first = 0
    for seq in fates.seq[rows[~corrupted]].tolist():
        if seq in came:
            found["duplicate"] += 1
        elif seq < newest:
            found["reordered"] += 1
        else:
            found["accepted"] += 1
            newest, first = seq, first or seq
        came.add(seq)
    found["lost"] = newest - first + 1 - sum(seq >= first for seq in came) if came else 0
    return found


def received_of(rows):
    inbox = Receiver(1, period_s=0.008, timeout_s=0.03)
    packer = Packer(1, period=0.008)
    packets = [packer.pack(0.1, 0.0, n * FRAME_NS) for n in range(60)]
    for n, (seq, bad) in enumerate(rows):
        inbox.push(refused(Receipt.CORRUPTED) if bad else packets[seq - 1], n)
    return ReceptionTraces("user1/up", 1, counts(inbox), passage(None))


@given(st.lists(st.tuples(st.integers(1, 60), st.booleans()), max_size=150))
def test_receiver_counts_what_the_link_did_whatever_that_was(rows):
    received, fates = received_of(rows), fates_of(rows)
    assert {name: received.counts[name] for name in OF_LINK} == done_by(fates, received)


DISTURBED = (
    "link.loss=0.05",
    "link.duplicate=0.04",
    "link.corrupt=0.03",
    "link.jitter=uniform",
    "link.jitter_s=0.012",
    "link.keep_order=false",
)


def test_a_session_counts_exactly_and_its_report_has_it(tmp_path):
    scenario = load("carry_16ms", duration_s=1.5, settings_texts=DISTURBED)
    traces = simulate_one(scenario)
    record_traces(tmp_path, traces, scenario)
    read = read_session(tmp_path)
    found = summary(read, scenario)
    words = unescape(render(read, scenario, found, []))
    assert {entry["name"] for entry in found["receptions"]} == set(traces.fates)
    for entry in found["receptions"]:
        received = read.receptions[entry["name"]]
        done = done_by(read.fates[entry["name"]], received)
        assert done.items() <= received.counts.items()
        for name in ("lost", "duplicate", "reordered", "corrupted"):
            assert entry["counts"][name] > 0, name
        assert read.receptions[entry["name"]].counts == traces.receptions[entry["name"]].counts
        row = "".join(f'<td class="n">{entry["counts"][name]}</td>' for name in OF_LINK)
        assert f"<td>{entry['name']}</td>{row}" in words


def test_the_messages_of_two_starts_are_added_up():
    from pmwvc_analysis.recording.links import reception_traces

    def message(epoch, seq, lost):
        values = {**counts(Receiver(1, period_s=0.008, timeout_s=0.03)), **passage(None)}
        stamp = SimpleNamespace(sec=seq, nanosec=0)
        return SimpleNamespace(**values | {"lost": lost}, epoch=epoch, seq=seq, stamp=stamp)

    found = reception_traces("user1/up", [message(1, 1, 3), message(1, 2, 5), message(2, 1, 1)])
    assert (found.receivers, found.counts["lost"]) == (2, 6)


def gaps(numbers):
    return Series(schemas.WAVE, [Decoded(0, 0, None, *each) for each in numbers]).gaps()


@given(st.lists(st.integers(1, 60), min_size=1, max_size=60, unique=True))
def test_gaps_are_what_is_not_there(numbers):
    absent = {*range(1, max(numbers) + 1)} - {*numbers}
    assert gaps(("a", number) for number in numbers) == {"a": (len(absent), len({*numbers}))}


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


def test_packets_of_another_sender_are_reported_once():
    rig = Rig("/netem")
    packet = Packer(0xABC, period=0.008).pack(0.0, 0.0, 0)
    rig.inbox.push(packet, 0)
    rig.inbox.push(dataclasses.replace(packet, epoch=0xDEF), 1)
    wrong, values = rig.peers.look()
    assert wrong == [f"{DOWN}: 1 packet of another sender refused"]
    assert values[f"{DOWN}: sender followed"].endswith("abc")
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
