# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of fates, and a link on record, which does to packet n what was done to packet n."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_core.network.in_flight import Cause, FateKind, FateLog, RecordedFate, RecordedLink
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams


def test_blocks_follow_one_another_without_a_gap():
    log = FateLog()
    link = Link(LinkParams(), seed=1)
    for n in range(5):
        log.add(link.send(n, n)[0])
    first, second = log.take(3), log.take(3)
    assert (first["first"], len(first["seq"])) == (1, 3)
    assert (second["first"], second["seq"].tolist()) == (4, [4, 5])
    assert len(log) == 0


def test_an_empty_block_has_typed_columns():
    block = FateLog().take()
    assert block["first"] == 1 and len(block["time_in_ns"]) == 0
    assert block["epoch"].dtype == np.uint64 and block["fate"].dtype == np.uint8


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


def test_twice_as_many_packets_meet_the_fates_recorded_at_their_time():
    lost = RecordedFate(None, FateKind.LOST, Cause.LOSS)
    record = {1: [RecordedFate(0)], 2: [lost], 3: [RecordedFate(0)]}
    link = RecordedLink(record, per_packet=0.5)
    kinds = [link.send(None, n * MS)[0].kind for n in range(6)]
    assert [kind is FateKind.LOST for kind in kinds] == [False, False, True, True, False, False]


def test_half_as_many_packets_meet_every_other_fate():
    record = {n: [RecordedFate(n * MS)] for n in range(1, 7)}
    link = RecordedLink(record, per_packet=2.0)
    assert [link.send(None, 0)[0].time_due_ns for _ in range(3)] == [MS, 3 * MS, 5 * MS]


@pytest.mark.parametrize("number", [1, 2])
def test_what_was_not_recorded_or_never_came_out_does_not_arrive(number):
    link = RecordedLink({1: [RecordedFate(None)]})
    fate = [link.send(None, 0) for _ in range(number)][-1][0]
    assert fate.time_due_ns == 0
    assert link.arrivals(10**12) == []
    assert link.counters.lost == number - 1
