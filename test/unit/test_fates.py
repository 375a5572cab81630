# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of fates; one relayed topic in invented time; a link on record, which does to packet
n what was done to packet n.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from pmwvc_core.network.in_flight import FateKind, FateLog, RecordedFate, RecordedLink
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams
from pmwvc_core.runtime import messages
from pmwvc_core.transport.packet import WavePacket
from pmwvc_netem.relayed_link import RelayedLink, peek_wave


def test_blocks_follow_one_another_without_a_gap_and_an_empty_one_has_typed_columns():
    log = FateLog()
    link = Link(LinkParams(), seed=1)
    for n in range(5):
        log.add(link.send(n, n)[0])
    first, second = log.take(3), log.take(3)
    assert (first["first"], len(first["seq"])) == (1, 3)
    assert (second["first"], second["seq"].tolist()) == (4, [4, 5])
    assert len(log) == 0
    empty = log.take()
    assert empty["first"] == 6 and len(empty["time_in_ns"]) == 0
    assert empty["epoch"].dtype == np.uint64 and empty["fate"].dtype == np.uint8


MS = 1_000_000


def driven(link, packets, *, period_ns=8 * MS, look_ns=MS):
    """Send packets, look at every millisecond; return what came out when."""
    out = []
    for now_ns in range(0, packets * period_ns + 200 * MS, look_ns):
        number, late = divmod(now_ns, period_ns)
        if not late and number < packets:
            link.send(number + 1, now_ns)
        out += [(now_ns, payload) for payload, _ in link.arrivals(now_ns)]
    return out


@given(
    st.integers(0, 2**31 - 1),
    st.floats(0.0, 0.05),
    st.floats(0.0, 0.5),
    st.floats(0.0, 0.5),
    st.floats(0.0, 0.02),
)
def test_what_a_link_did_is_done_again(seed, delay_s, loss, duplicate, jitter_s):
    params = LinkParams(
        delay_s=delay_s,
        loss=loss,
        duplicate=duplicate,
        jitter="uniform",
        jitter_s=jitter_s,
        keep_order=False,
    )
    link, fates = Link(params, seed=seed), []

    class Noting:
        arrivals = link.arrivals

        def send(self, payload, now_ns):
            fates.extend(link.send(payload, now_ns))

    there = driven(Noting(), 40)
    record = {}
    for fate in fates:
        out = fate.kind in (FateKind.DELIVERED, FateKind.DUPLICATE)
        delay = fate.time_due_ns - fate.time_in_ns if out else None
        record.setdefault(fate.number, []).append(RecordedFate(delay, fate.kind, fate.cause))
    again = RecordedLink(record)
    assert driven(again, 40) == there
    assert again.counters == link.counters


@pytest.mark.parametrize("number", [1, 2])
def test_what_was_not_recorded_or_never_came_out_does_not_arrive(number):
    link = RecordedLink({1: [RecordedFate(None)]})
    fate = [link.send(None, 0) for _ in range(number)][-1][0]
    assert fate.time_due_ns == 0
    assert link.arrivals(10**12) == []
    assert link.counters.lost == number - 1


LIVE = messages.live_types()


def serialized(epoch, seq):
    packet = WavePacket(epoch, seq, 5, 0.008, 1.0, 1.0, 1.0, 1.0)
    return serialize_message(messages.wave(LIVE, packet, 1))


class Bench:
    """A relayed with its ends in memory and a clock that is set by hand."""

    def __init__(self, params, *, seed=1):
        self.now_ns = 0
        self.before = []
        self.after = []
        self.relayed = RelayedLink(
            "user1/up",
            Link(params, seed=seed),
            take=lambda: self.before.pop(0) if self.before else None,
            give=lambda message: self.after.append((self.now_ns, message)),
            clock=lambda: self.now_ns,
        )

    def at(self, now_ns, *arriving):
        self.now_ns = now_ns
        self.before += arriving
        self.relayed.take_in()
        self.relayed.let_out()


@given(epoch=st.integers(0, 2**64 - 1), seq=st.integers(0, 2**32 - 1))
def test_epoch_and_number_are_found_where_the_encoding_puts_them(epoch, seq):
    assert peek_wave(serialized(epoch, seq)) == (epoch, seq)
    other_order = epoch.to_bytes(8, "big") + seq.to_bytes(4, "big")
    assert peek_wave(bytes(20) + other_order) == (epoch, seq)


@pytest.mark.parametrize("length", [0, 1, 4, 31])
def test_a_message_too_short_or_of_an_unknown_encoding_is_no_wave(length):
    assert peek_wave(serialized(1, 1)[:length]) is None
    assert peek_wave(b"\x00\x07" + serialized(1, 1)[2:]) is None


def test_a_message_leaves_when_due_as_it_came_and_is_written_down_then():
    bench = Bench(LinkParams(delay_s=0.010))
    message = serialized(3, 4)
    bench.at(2 * MS, message)
    bench.at(12 * MS - 1)
    assert bench.after == [] and len(bench.relayed.fates) == 0
    bench.at(13 * MS)
    assert bench.after == [(13 * MS, message)]
    block = bench.relayed.fates.take()
    assert block.pop("first") == 1
    assert {name: int(column[0]) for name, column in block.items()} == {
        **{"epoch": 3, "seq": 4, "bytes": len(message), "fate": FateKind.DELIVERED, "cause": 0},
        **{"time_in_ns": 2 * MS, "time_due_ns": 12 * MS, "time_out_ns": 13 * MS},
    }


def test_what_is_no_message_is_written_down_and_the_rest_goes_on():
    bench = Bench(LinkParams())
    bench.at(MS, serialized(1, 1), b"\x00\x01", serialized(1, 2))
    block = bench.relayed.fates.take()
    assert sorted(block["fate"]) == [FateKind.DELIVERED, FateKind.DELIVERED, FateKind.INVALID]
    assert bench.relayed.invalid == 1
    assert bench.relayed.link.counters.in_count == 2  # it draws no random numbers
    assert len(bench.after) == 2


def test_what_is_under_way_at_the_end_is_written_down_as_never_out():
    bench = Bench(LinkParams(delay_s=1.0))
    bench.at(MS, serialized(1, 1))
    bench.relayed.end()
    block = bench.relayed.fates.take()
    assert (block["time_due_ns"][0], block["time_out_ns"][0]) == (1001 * MS, 0)
    assert bench.after == []


def test_the_latest_release_is_noted():
    bench = Bench(LinkParams(delay_s=0.010))
    bench.at(0, serialized(1, 1))
    bench.at(2 * MS, serialized(1, 2))
    bench.at(11 * MS)
    bench.at(15 * MS)
    assert bench.relayed.late_ns == 3 * MS
