# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Order, copies, gaps and corruption are counted at the receivers exactly as they were injected,
and the report says so in words.
"""

from html import unescape
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.packer import Packer
from support.plain import load

from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.report.report import render
from pmwvc_analysis.verdicts.links import (
    OF_LINK,
    counts_text,
    done_by,
    path_text,
)
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import FateTraces, ReceptionTraces
from pmwvc_core.transport.packet import Receipt, refused
from pmwvc_core.transport.receiver import PASSAGE, Receiver, counts, passage

FRAME_NS = 8_000_000


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
    injected = done_by(fates, received)
    if not rows:
        return
    assert {name: received.counts[name] for name in OF_LINK} == injected
    assert "exactly what the emulated link did" in counts_text(received, injected)


def test_a_packet_lost_behind_the_link_is_no_exact_count():
    rows = [(seq, False) for seq in range(1, 50)]
    received = received_of([row for row in rows if row[0] != 20])
    text = counts_text(received, done_by(fates_of(rows), received))
    assert "1 number never came" in text and "0 lost" in text
    assert "the difference arose between the link and the receiver" in text


def test_a_link_whose_record_is_not_whole_is_not_compared():
    rows = [(seq, False) for seq in range(1, 50)]
    fates = fates_of(rows)
    fates.number = fates.number + 3  # the first three were not recorded
    assert done_by(fates, received_of(rows)) is None
    assert done_by(fates_of(rows[:40]), received_of(rows)) is None


DISTURBED = (
    "link.loss=0.05",
    "link.duplicate=0.04",
    "link.corrupt=0.03",
    "link.jitter=uniform",
    "link.jitter_s=0.012",
    "link.keep_order=false",
)


def test_a_session_counts_exactly_and_its_report_says_so(tmp_path):
    scenario = load("carry_16ms", duration_s=3.0, settings_texts=DISTURBED)
    traces = simulate_one(scenario)
    record_traces(tmp_path, traces, scenario)
    read = read_session(tmp_path)
    found = summary(read, scenario)
    words = unescape(render(read, scenario, found, []))
    assert {entry["name"] for entry in found["receptions"]} == set(traces.fates)
    for entry in found["receptions"]:
        assert entry["as_injected"] is True
        for name in ("lost", "duplicate", "reordered", "corrupted"):
            assert entry["counts"][name] > 0, name
        assert read.receptions[entry["name"]].counts == traces.receptions[entry["name"]].counts
        assert entry["text"] in words


def test_a_receiver_that_was_started_again_is_not_compared():
    rows = [(seq, False) for seq in range(1, 50)]
    received = received_of(rows)
    received.receivers = 2
    assert done_by(fates_of(rows), received) is None
    assert "exactly" not in counts_text(received, None)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({}, "Delay not known"),
        ({"round_trip": 0.03, "delay_open": 0.0}, "both ends read one clock"),
        ({"round_trip": 0.03, "delay_open": 0.015}, "look the same"),
    ],
)
def test_the_path_says_what_is_known_and_what_is_not(changed, words):
    known = dict.fromkeys(PASSAGE, 0.015) | changed if changed else passage(None)
    assert words in path_text(known)


def test_the_messages_of_two_starts_are_added_up():
    from pmwvc_analysis.recording.links import reception_traces

    def message(epoch, seq, lost):
        values = {**counts(Receiver(1, period_s=0.008, timeout_s=0.03)), **passage(None)}
        stamp = SimpleNamespace(sec=seq, nanosec=0)
        return SimpleNamespace(**values | {"lost": lost}, epoch=epoch, seq=seq, stamp=stamp)

    found = reception_traces("user1/up", [message(1, 1, 3), message(1, 2, 5), message(2, 1, 1)])
    assert (found.receivers, found.counts["lost"]) == (2, 6)
