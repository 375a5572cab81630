# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a link does over time: recorded delays, and the timeline of settings, networks,
ramps and outages.
"""

from dataclasses import replace

import pytest
from support.plain import load

from pmwvc_core.errors import ParameterError, RecordingError, ScenarioError
from pmwvc_core.network.delay_trace import load_delay_trace
from pmwvc_core.network.distributions import DISTRIBUTIONS
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.network.link import Link
from pmwvc_core.network.presets import PRESETS
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


S = 1_000_000_000


def timed(schedule, *, direction=0, **settings):
    params = LinkParams(schedule=schedule, keep_order=False, **settings)
    return Link(params, seed=1, direction=direction)


def delays_ms(channel, times_s, start_ns=7 * S):
    found = []
    for time_s in times_s:
        fate = channel.send(None, start_ns + round(time_s * S))[0]
        lost = fate.kind is FateKind.LOST
        found.append(fate.cause if lost else (fate.time_due_ns - fate.time_in_ns) / MS)
    return found


def test_settings_hold_from_their_time_to_the_next_entry():
    channel = timed("1 delay_s=0.05; 2 outage; 3 base", delay_s=0.01)
    times = (0.0, 0.999, 1.0, 1.999, 2.0, 2.999, 3.0, 9.0)
    out = Cause.OUTAGE
    assert delays_ms(channel, times) == [10.0, 10.0, 50.0, 50.0, out, out, 10.0, 10.0]


def test_an_entry_names_what_differs_from_the_link_and_not_from_the_entry_before():
    channel = timed("1 delay_s=0.05; 2 loss=1", delay_s=0.01)
    assert delays_ms(channel, (0.0, 1.5, 2.5)) == [10.0, 50.0, Cause.LOSS]
    channel = timed("1 loss=1; 2 delay_s=0.05")
    assert delays_ms(channel, (0.0, 1.5, 2.5)) == [0.0, Cause.LOSS, 50.0]


def test_a_ramp_goes_straight_to_the_next_entry_and_a_timeline_may_begin_anew():
    channel = timed("0 delay_s=0.02..0.1; 4 delay_s=0.1..0.02; 8 repeat")
    found = delays_ms(channel, (0.0, 1.0, 2.0, 4.0, 6.0, 8.0, 9.0))
    assert found == pytest.approx([20.0, 40.0, 60.0, 100.0, 60.0, 20.0, 40.0])


@pytest.mark.parametrize("direction, way", [(0, "up"), (1, "down")])
def test_a_network_by_name_has_the_settings_of_the_direction(direction, way):
    channel = timed("1 lte jitter=none slot_max_s=0 slot_min_s=0", direction=direction)
    wanted = getattr(PRESETS["lte"], way).delay_s * 1e3
    assert delays_ms(channel, (0.0, 1.0)) == [0.0, pytest.approx(wanted)]


def test_random_numbers_go_on_through_a_timeline():
    plain = Link(LinkParams(loss=0.3, keep_order=False), seed=1)
    other = timed("0.02 delay_s=0.5; 0.05 base", loss=0.3)
    kinds = [[each.send(n, n * MS)[0].kind for n in range(100)] for each in (plain, other)]
    assert kinds[0] == kinds[1]


def test_new_settings_keep_the_clock_of_the_timeline():
    channel = timed("5 outage", delay_s=0.01)
    assert delays_ms(channel, (0.0, 4.0)) == [10.0, 10.0]
    channel.configure(LinkParams(schedule="5 outage", delay_s=0.02, keep_order=False))
    assert delays_ms(channel, (4.5, 5.5)) == [20.0, Cause.OUTAGE]


@pytest.mark.parametrize(
    "schedule, text",
    [
        ("3 outage; 2 base", r"entry 2 '2 base': time = 2: must be 3..1e\+06 s"),
        ("-1 outage", r"entry 1 '-1 outage': time = -1: must be 0"),
        ("soon outage", r"time = soon: must be 0"),
        ("3", r"entry 1 '3': must be TIME SETTINGS"),
        ("3 outage loss=1", "'outage': must be one network by name"),
        ("3 lten", r"'lten': must be .*did you mean lte"),
        ("3 lte geo", "'geo': must be one network"),
        ("3 torture", "'torture' has a timeline itself"),
        ("3 loss=2", r"loss = 2.0: must be 0..1"),
        ("3 los=0.2", r"'los': there is no such setting; did you mean loss"),
        ("3 delay_s=0.1..0.2", "a ramp needs a later entry"),
        ("3 delay_s=0.1..99; 4 base", r"delay_s = 99.0: must be 0..60 s"),
        ("3 repeat; 4 base", "nothing may come after repeat"),
        ("3 reorder=0.5 keep_order=true", "entry at 3 s: reorder = 0.5"),
    ],
)
def test_a_timeline_that_cannot_be_is_refused_with_entry_value_and_range(schedule, text):
    with pytest.raises(ParameterError, match=text):
        timed(schedule)
    with pytest.raises(ScenarioError, match=rf"user1.link.up.schedule: .*{text}"):
        load("carry_16ms", settings_texts=[f"link.schedule={schedule}", "link.keep_order=false"])


def test_no_packet_waits_for_a_distribution_that_a_timeline_brings_later(monkeypatch):
    """Its library takes 0.3 s to load: a whole outage where an emulator does it in between."""
    asked = []
    law = replace(DISTRIBUTIONS["gamma"], at=lambda params, u: asked.append(u) or 0.0)
    monkeypatch.setitem(DISTRIBUTIONS, "gamma", law)
    timed("5 loss=0.1")
    assert not asked
    timed("5 jitter=gamma jitter_s=0.01")
    assert asked
