# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The link: integers in, integers out."""

import numpy as np
import pytest

from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams

MS = 1_000_000


def link(seed=1, **settings):
    return Link(LinkParams(**settings), seed=seed)


def payloads(arrivals):
    return [payload for payload, _ in arrivals]


def delays_of(channel, count, *, every_ns=MS):
    """Return the delays of packets sent one after the other [ns]."""
    fates = [channel.send(n, n * every_ns)[0] for n in range(count)]
    return np.array([fate.time_due_ns - fate.time_in_ns for fate in fates])


def test_a_link_is_a_delay_line():
    channel = link(delay_s=0.016)
    for n in range(3):
        channel.send(n, n * 8 * MS)
    out = {t: payloads(channel.arrivals(t * MS)) for t in range(0, 40, 8)}
    assert out == {0: [], 8: [], 16: [0], 24: [1], 32: [2]}


def test_a_fate_states_number_times_size_and_kind():
    channel = link(delay_s=0.002)
    channel.send("a", 0)
    (fate,) = channel.send("b", 1000, size_bytes=126)
    assert (fate.number, fate.time_in_ns, fate.time_due_ns) == (2, 1000, 1000 + 2 * MS)
    assert (fate.kind, fate.cause, fate.size) == (FateKind.DELIVERED, Cause.NONE, 126)


def test_everything_is_lost_or_nothing():
    (fate,) = link(loss=1.0).send("a", 7)
    assert (fate.kind, fate.cause, fate.time_due_ns) == (FateKind.LOST, Cause.LOSS, 0)
    assert link(loss=0.0).send("a", 7)[0].kind is FateKind.DELIVERED


def test_a_copy_comes_out_beside_its_original():
    channel = link(duplicate=1.0, delay_s=0.001)
    original, copy = channel.send("a", 0)
    assert (copy.number, copy.kind, copy.cause) == (1, FateKind.DUPLICATE, Cause.DUPLICATION)
    assert channel.arrivals(MS) == [("a", original), ("a", copy)]
    assert (channel.counters.duplicated, channel.counters.out_count) == (1, 2)


def test_the_rate_limit_is_a_serial_line():
    # 1000 bytes at 1 Mbit/s take 8 ms each.
    channel = link(rate_limit_bps=1e6, delay_s=0.001)
    due = [channel.send(n, 0, size_bytes=1000)[0].time_due_ns for n in range(3)]
    assert due == [9 * MS, 17 * MS, 25 * MS]
    assert channel.send(3, 100 * MS, size_bytes=500)[0].time_due_ns == 105 * MS


def test_more_packets_than_may_wait_for_the_line_are_dropped():
    channel = link(rate_limit_bps=1e6, queue_packets=2)
    kinds = [channel.send(n, 0, size_bytes=1000)[0].kind for n in range(5)]
    # One on the line, two waiting.
    assert kinds == [FateKind.DELIVERED] * 3 + [FateKind.DROPPED_QUEUE] * 2
    assert channel.counters.dropped == 2
    (dropped,) = channel.send(5, MS, size_bytes=1000)
    assert (dropped.time_due_ns, dropped.cause) == (0, Cause.QUEUE_FULL)
    assert channel.send(6, 8 * MS, size_bytes=1000)[0].kind is FateKind.DELIVERED


def test_new_settings_leave_packets_under_way_alone():
    channel = link(delay_s=0.1)
    channel.send("slow", 0)
    channel.configure(LinkParams(delay_s=0.0, keep_order=False))
    channel.send("fast", MS)
    assert payloads(channel.arrivals(MS)) == ["fast"]
    assert payloads(channel.arrivals(100 * MS)) == ["slow"]


def test_a_shorter_delay_with_order_kept_does_not_overtake():
    channel = link(delay_s=0.1, keep_order=False)
    channel.send("slow", 0)
    channel.configure(LinkParams(delay_s=0.0, keep_order=True))
    (fate,) = channel.send("fast", MS)
    assert fate.time_due_ns == 100 * MS
    assert payloads(channel.arrivals(100 * MS)) == ["slow", "fast"]


def test_once_order_is_kept_the_latest_under_way_is_what_counts():
    channel = link(delay_s=0.1, keep_order=False)
    channel.send("slow", 0)
    channel.configure(LinkParams(delay_s=0.0, keep_order=False))
    channel.send("overtaking", MS)
    channel.configure(LinkParams(delay_s=0.0, keep_order=True))
    assert channel.send("in order", 2 * MS)[0].time_due_ns == 100 * MS


@pytest.mark.parametrize("keep_order", [True, False])
@pytest.mark.parametrize(
    ("before", "after"),
    [
        ({"rate_limit_bps": 1e5}, {}),
        ({"rate_limit_bps": 1e5}, {"rate_limit_bps": 1e9}),
        ({"delay_s": 1.0}, {}),
        ({"schedule": "0 rate_limit_bps=1e5; 5 base"}, {"schedule": "0 base"}),
    ],
)
def test_a_queue_that_need_not_wait_any_longer_empties_twice_as_fast_as_it_filled(
    before, after, keep_order
):
    """Without order the new packets overtake it: neither way do many come out at once."""
    common = {"delay_s": 0.016, "keep_order": keep_order}
    channel, dues = link(**{**common, **before}), []
    for n in range(2000):
        if n == 625 and "schedule" not in before:
            channel.configure(LinkParams(**{**common, **after}))
        (fate,) = channel.send(n, n * 8 * MS)
        dues.append(fate.time_due_ns)
    delays_ms = np.array(dues) / MS - 8.0 * np.arange(2000)
    arrived = np.sort(dues)[np.sort(dues) > 0]
    at_once = np.searchsorted(arrived, arrived + 4 * MS) - np.arange(len(arrived))
    assert at_once.max() <= 2
    waited_ms = delays_ms[:625].max()
    over = 625 + int(2 * waited_ms / 8) + 4
    np.testing.assert_allclose(delays_ms[over:], 16.0, atol=0.01)


def test_counters_tell_what_is_inside():
    channel = link(delay_s=0.01)
    channel.send("a", 0)
    channel.send("b", 5 * MS)
    assert (channel.counters.in_count, channel.counters.queued) == (2, 2)
    channel.arrivals(10 * MS)
    assert (channel.counters.out_count, channel.counters.queued) == (1, 1)


def test_directions_and_users_have_streams_of_their_own():
    settings = {"jitter": "uniform", "jitter_s": 0.01, "delay_s": 0.02, "keep_order": False}
    streams = [(5, user, direction) for user in range(2) for direction in range(2)]
    found = [delays_of(link(seed, **settings), 500) for seed in streams]
    correlation = np.corrcoef(found) - np.eye(4)
    assert np.abs(correlation).max() < 4.0 / np.sqrt(500)
