# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The link, integers in and out, and its effects one by one: line, slots, reordering, tables."""

import json
import re

import numpy as np
import pytest

from pmwvc_core.errors import ParameterError, RecordingError
from pmwvc_core.network.delay_trace import load_delay_trace
from pmwvc_core.network.distributions import DISTRIBUTIONS
from pmwvc_core.network.effects import conflicts, longest_s, mean_s
from pmwvc_core.network.in_flight import Cause, Fate, FateKind
from pmwvc_core.network.link import Link
from pmwvc_core.network.queues import Slots
from pmwvc_core.params import LinkParams

MS = 1_000_000


def link(seed=1, **settings):
    return Link(LinkParams(**settings), seed=seed)


def test_the_rate_limit_is_a_serial_line():
    # 1000 bytes at 1 Mbit/s take 8 ms each.
    channel = link(rate_limit_bps=1e6, delay_s=0.001)
    due = [channel.send(n, 0, size_bytes=1000)[0].time_due_ns for n in range(3)]
    assert due == [9 * MS, 17 * MS, 25 * MS]
    assert channel.send(3, 100 * MS, size_bytes=500)[0].time_due_ns == 105 * MS
    headed = link(rate_limit_bps=1e6, rate_overhead_bytes=25)
    assert dues_ms(headed, [0], 100) == [1.0]


@pytest.mark.parametrize("bound", [{"queue_packets": 2}, {"queue_bytes": 2500}], ids=str)
def test_more_than_may_wait_for_the_line_is_dropped(bound):
    """One is on the line, two wait."""
    channel = link(rate_limit_bps=1e6, **{"queue_packets": 100, **bound})
    kinds = [channel.send(n, 0, size_bytes=1000)[0].kind for n in range(5)]
    assert kinds == [FateKind.DELIVERED] * 3 + [FateKind.DROPPED_QUEUE] * 2
    assert channel.counters.dropped == 2
    (dropped,) = channel.send(5, MS, size_bytes=1000)
    assert (dropped.time_due_ns, dropped.cause) == (0, Cause.QUEUE_FULL)
    if "queue_bytes" in bound:  # this still fits
        assert channel.send(6, MS, size_bytes=500)[0].kind is FateKind.DELIVERED
    assert channel.send(7, 8 * MS, size_bytes=1000)[0].kind is FateKind.DELIVERED


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


def dues_ms(channel, times_ms, size_bytes=140):
    sent = [channel.send(n, t * MS, size_bytes=size_bytes)[0] for n, t in enumerate(times_ms)]
    return [fate.time_due_ns / MS for fate in sent]


def test_packets_that_are_sent_at_once_overtake():
    channel = link(seed=1, delay_s=0.1, reorder=0.2, keep_order=False)
    dues = dues_ms(channel, range(50))
    first = [n for n, due in enumerate(dues) if due == n]
    assert 5 <= len(first) <= 15
    out = [payload for payload, _ in channel.arrivals(10**12)]
    assert out == first + [n for n in range(50) if n not in first]


def test_a_packet_that_takes_minutes_leaves_the_slots_of_those_after_it():
    slots, p, second_ns = Slots(lambda number: 0.5), LinkParams(slot_max_s=0.02), 1_000_000_000
    for in_s, due_s, arrives_s in ((0, 450, 450), (1, 1.003, 1.01), (2, 400, 400), (3, 3, 3)):
        times_ns = round(due_s * second_ns), round(arrives_s * second_ns)
        fate = Fate(1, in_s * second_ns, size=140)
        assert slots.arrives_ns(p, fate, times_ns[0], 0) == times_ns[1]


@pytest.mark.parametrize("jitter", ["gamma", "lognormal", "pareto", "quantiles"])
def test_moments_that_are_named_are_those_of_the_quantile_function(jitter):
    params = LinkParams(
        jitter=jitter, jitter_s=0.01, jitter_quantiles="0:0.001 0.5:0.002 0.9:0.02 1:0.1"
    )
    law = DISTRIBUTIONS[jitter]
    edge = np.concatenate(([0.0], 1.0 - np.geomspace(1.0, 1e-14, 20_000)))
    middles, widths = (edge[1:] + edge[:-1]) / 2.0, np.diff(edge)
    values = np.array([law.at(params, u) for u in middles])
    mean = (values * widths).sum()
    deviation = np.sqrt(((values - mean) ** 2 * widths).sum())
    assert law.moments(params) == (
        pytest.approx(mean, abs=1e-5),
        pytest.approx(deviation, rel=5e-3),
    )
    assert mean_s(params) == pytest.approx(law.moments(params)[0])
    assert longest_s(params) >= mean_s(params)


@pytest.mark.parametrize(
    "settings, text",
    [
        ({"jitter": "pareto", "jitter_s": 0.1, "jitter_shape": 2.0}, r"jitter_shape = 2: .* > 2"),
        ({"jitter": "quantiles"}, r"jitter_quantiles = '': must be probability:seconds"),
        ({"jitter": "quantiles", "jitter_quantiles": "0:1 0.5:0.2 1:2"}, "rising"),
        ({"jitter": "table"}, "trace_file is missing: jitter = table needs a file"),
        ({"slot_min_s": 0.2, "slot_max_s": 0.1}, r"slot_min_s = 0.2: must be 0..slot_max_s = 0.1"),
        (
            {"handover_s": 1.0, "handover_outage_min_s": 2.0},
            r"handover_outage_min_s = 2: must be 0..handover_outage_max_s = 0",
        ),
    ],
)
def test_settings_that_contradict_each_other_are_named_with_value_and_range(settings, text):
    params = LinkParams(**settings)
    (problem,) = conflicts(params)
    assert re.search(text, problem)
    with pytest.raises((ParameterError, RecordingError)):
        Link(params, seed=1)


def test_a_table_is_drawn_from_and_its_losses_are_not(tmp_path):
    path = tmp_path / "delays.csv"
    path.write_text("time_s,delay_ms\n0,10\n1,20\n2,lost\n3,60\n")
    settings = {"jitter": "table", "trace_file": str(path), "trace_scale": 0.001}
    dues = dues_ms(link(**settings, keep_order=False), [0] * 3000)
    counts = [dues.count(delay) for delay in (10.0, 20.0, 60.0)]
    assert sum(counts) == 3000 and min(counts) > 900


def test_sending_and_receiving_times_give_delays_and_losses(tmp_path):
    path = tmp_path / "packets.csv"
    path.write_text(
        "seq,send_time_ms,receive_time_ms\n1,0,25\n2,8,lost\n3,16,46\n4,24,\n5,32,60\n"
    )
    channel = link(jitter="trace", trace_file=str(path), keep_order=False)
    fates = [channel.send(n, 8 * n * MS)[0] for n in range(5)]
    kinds = [fate.kind is FateKind.LOST for fate in fates]
    assert kinds == [False, True, False, True, False]
    assert [f.time_due_ns - f.time_in_ns for f in fates[::2]] == [25 * MS, 30 * MS, 28 * MS]
    assert load_delay_trace(str(path), 1.0).lost_ratio == pytest.approx(0.4)


def trip(number, sent_ns, send=0, receive=0, lost="false"):
    delay = {"send": send, "receive": receive, "rtt": send + receive} if lost == "false" else {}
    if lost == "true_down":
        delay = {"send": send}
    sent = {"wall": 10**18 + sent_ns, "monotonic": sent_ns}
    return {
        "seqno": number,
        "lost": lost,
        "timestamps": {"client": {"send": sent, "receive": {}}, "server": {}},
        "delay": delay,
    }


def test_round_trips_of_irtt_are_read_by_direction(tmp_path):
    trips = [
        trip(0, 0, 9 * MS, 5 * MS),
        trip(1, 20 * MS, 7 * MS, lost="true_down"),
        trip(2, 40 * MS, lost="true_up"),
        trip(3, 60 * MS, 8 * MS, 6 * MS),
    ]
    path = tmp_path / "irtt.json"
    path.write_text(json.dumps({"version": {}, "round_trips": trips}))
    found = {
        column: load_delay_trace(str(path), 1.0, column).delay_ns
        for column in ("send", "receive", "rtt")
    }
    assert found["send"] == (9 * MS, 7 * MS, -1, 8 * MS)
    assert found["receive"] == (5 * MS, -1, -1, 6 * MS)
    assert load_delay_trace(str(path), 0.5).delay_ns == (7 * MS, -1, -1, 7 * MS)
    assert load_delay_trace(str(path), 1.0).time_ns == (0, 20 * MS, 40 * MS, 60 * MS)
