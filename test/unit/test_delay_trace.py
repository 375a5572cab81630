# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded delays: what is read from a file, and what a link makes of it."""

import numpy as np
import pytest

from pmwvc_core.errors import RecordingError
from pmwvc_core.network.delay_trace import load_delay_trace
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams

MS = 1_000_000


def link(**settings):
    return Link(LinkParams(jitter="trace", **settings), seed=1)


def write(tmp_path, text):
    path = tmp_path / "delays.txt"
    path.write_text(text)
    return str(path)


def test_a_recorded_delay_holds_until_the_next_row_and_starts_again(tmp_path):
    path = write(tmp_path, "0.0, 10\n0.1, 20\n0.2, 30\n")
    channel = link(trace_file=path, trace_scale=0.001, keep_order=False)
    start = 7_777_777_777
    delays = {
        t: channel.send(0, start + t * MS)[0].time_due_ns - start - t * MS
        for t in (0, 99, 100, 250, 299, 300, 450)
    }
    in_ms = {t: delay // MS for t, delay in delays.items()}
    assert in_ms == {0: 10, 99: 10, 100: 20, 250: 30, 299: 30, 300: 10, 450: 20}


def test_an_outage_in_order_becomes_a_burst(tmp_path):
    path = write(tmp_path, "time,delay\n0,0.001\n0.01,0.05\n0.02,0.001\n0.03,0.001\n")
    channel = link(trace_file=path)
    due = [channel.send(n, n * 10 * MS)[0].time_due_ns // MS for n in range(4)]
    assert due == [1, 60, 60, 60]


def test_pauses_of_the_recording_are_joined(tmp_path):
    trace = load_delay_trace(write(tmp_path, "0 1\n0.1 2\n60.1 3\n60.2 4\n"), 1.0)
    assert trace.time_ns == (0, 100 * MS, 200 * MS, 300 * MS)
    assert trace.length_ns == 400 * MS


@pytest.mark.parametrize(
    "header, unit_s",
    [("time_ms delay_ms", 1e-3), ("pub_time(ms) delay(ms)", 1e-3), ("t rtt", 1.0)],
)
def test_the_header_names_the_columns_and_the_unit_of_time(tmp_path, header, unit_s):
    time, delay = header.split()
    path = write(tmp_path, f"# a note\n{delay};x;{time}\n7;a;{0.1 / unit_s}\n8;b;{0.2 / unit_s}\n")
    trace = load_delay_trace(path, 0.001)
    assert trace.time_ns == (0, 100 * MS)
    assert trace.delay_ns == (7 * MS, 8 * MS)


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "holds no row"),
        ("0 1\n", "at least two rows"),
        ("time lag\n0 1\n1 1\n", "no column named delay or rtt or latency; there are time, lag"),
        ("0 1\n1 x\n", "row 2 has no number in column 1 .time. or 2 .delay.: 1 x"),
        ("0 1\n1\n", "row 2 has no number"),
        ("1 1\n0 1\n", "times must not go back"),
        ("0 1\n1 -1\n", "delays must not be negative"),
        ("0 1\n1 nan\n", "delays must not be negative"),
        ("1 1\n1 1\n", "all rows have the same time"),
        ("{}", r"delays.txt: JSON, but not of IRTT"),
        ('{"round_trips": [{"lost": "false"}]}', "must hold round_trips"),
        ("0 lost\n1 lost\n", "every packet is lost"),
        ("0 0.1\n1 90\n", r"delay of 90 s in data row 2: .* above 60 s"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_with_the_reason(tmp_path, text, message):
    with pytest.raises(RecordingError, match=message):
        load_delay_trace(write(tmp_path, text), 1.0)


@pytest.mark.parametrize(
    "name, rows, p50_ms, p99_ms, longest_ms, length_s",
    [
        ("cicv5g_urban_n78.txt", 8170, 18, 33, 43, 135.2),
        ("cicv5g_w2s_n8.txt", 1300, 19, 376, 775, 71.6),
    ],
)
def test_recorded_5g_delays_are_read_by_their_columns(
    recorded_data, name, rows, p50_ms, p99_ms, longest_ms, length_s
):
    trace = load_delay_trace(str(recorded_data / name), 0.001)
    delays = np.array(trace.delay_ns) / MS
    assert len(delays) == rows
    assert np.median(delays) == p50_ms
    assert np.percentile(delays, 99) == pytest.approx(p99_ms, rel=0.02)
    assert delays.max() == longest_ms
    assert trace.length_ns * 1e-9 == pytest.approx(length_s, abs=0.1)
