# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Clocks of several hosts are aligned by the echoes of packets, never by wall time."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from support import handmade

from pmwvc_analysis.recording import clocks
from pmwvc_analysis.recording.clocks import ECHO, ONE_HOST, align
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.traces import FateTraces

FRAME_NS = 8_000_000
THETA_NS = 3_600_000_000_000 + 123_456  # hosts started an hour apart


def conversation(
    *,
    theta_ns=THETA_NS,
    drift=0.0,
    up_ns=300_000,
    down_ns=300_000,
    jitter_ns=0,
    seconds=40,
    link=0,
):
    """Packets both ways: what each end sends, with the echoes of what it got before.

    ``link`` is the delay of an emulated link each way [ns], told by its fates.
    """
    random = np.random.default_rng(7)
    count = seconds * 1_000_000_000 // FRAME_NS
    sent_m = np.arange(count, dtype=np.int64) * FRAME_NS + 5_000_000_000

    def server_clock(master_ns):
        return master_ns + theta_ns + np.round(drift * (master_ns - sent_m[0])).astype(np.int64)

    sent_true = sent_m + 2_000_000  # the server steps 2 ms after the masters send
    late = random.integers(0, jitter_ns + 1, (2, count))
    arrived_s = sent_m + up_ns + link + late[0]
    arrived_m = sent_true + down_ns + link + late[1]
    of_server, of_master = [], []
    for k in range(count):
        for own, peer, came, result, here, there in (
            (sent_true, sent_m, arrived_s, of_server, server_clock, np.asarray),
            (sent_m, sent_true, arrived_m, of_master, np.asarray, server_clock),
        ):
            newest = int(np.searchsorted(came, own[k], "right")) - 1
            if newest < 0:
                continue
            hold = int(here(own[k]) - here(came[newest]))
            result.append(
                SimpleNamespace(
                    sent_ns=int(here(own[k])),
                    echo_seq=newest + 1,
                    echo_sent_ns=int(there(peer[newest])),
                    echo_hold_ns=hold,
                )
            )
    return of_master, of_server, sent_m, server_clock


def fates(count, delay_ns):
    numbers = np.arange(1, count + 1)
    zeros = np.zeros(count, dtype=np.int64)
    return FateTraces(
        link="user1/up",
        number=numbers,
        epoch=np.ones(count, dtype=np.uint64),
        seq=numbers,
        size_bytes=zeros,
        time_in_ns=zeros + 1000,
        time_due_ns=zeros + 1000 + delay_ns,
        time_out_ns=zeros + 1000 + delay_ns,
        fate=zeros,
        cause=zeros,
    )


def test_one_host_needs_no_alignment():
    of_master, of_server, sent, _ = conversation(theta_ns=0, jitter_ns=3_000_000)
    found = align(of_master, of_server)
    assert found.how == ONE_HOST
    np.testing.assert_array_equal(found.to_server(sent), sent)


@pytest.mark.parametrize("jitter_ns", [0, 5_000_000])
def test_two_hosts_are_aligned_within_the_reported_uncertainty(jitter_ns):
    of_master, of_server, sent, server_clock = conversation(jitter_ns=jitter_ns)
    found = align(of_master, of_server)
    assert found.how == ECHO
    off_s = np.abs(found.to_server(sent) - server_clock(sent)) * 1e-9
    assert off_s.max() <= found.uncertainty_s + 1e-9
    assert found.uncertainty_s < 5e-3


def test_asymmetric_delays_are_within_the_reported_uncertainty():
    of_master, of_server, sent, server_clock = conversation(up_ns=9_000_000, down_ns=200_000)
    found = align(of_master, of_server)
    off_s = np.abs(found.to_server(sent) - server_clock(sent)) * 1e-9
    assert 3e-3 < off_s.max() <= found.uncertainty_s + 1e-9


def test_drift_is_followed():
    of_master, of_server, sent, server_clock = conversation(drift=50e-6, seconds=60)
    found = align(of_master, of_server)
    assert found.rate == pytest.approx(50e-6, rel=0.05)
    off_s = np.abs(found.to_server(sent) - server_clock(sent)) * 1e-9
    assert off_s.max() <= found.uncertainty_s + 1e-9
    assert off_s.max() < 1e-3  # without it: 3 ms


@pytest.mark.parametrize("last", [500, 2500])
@pytest.mark.parametrize("drift", [-100e-6, 100e-6])
def test_a_path_whose_ways_change_places_stays_within_the_reported_uncertainty(last, drift):
    """No line fits all of it; that of the last windows leaves the drift open before them."""
    up_ns = np.where(np.arange(5000) < 5000 - last, 20_000_000, 300_000)
    ways = {"up_ns": up_ns, "down_ns": 20_300_000 - up_ns}
    of_master, of_server, sent, server_clock = conversation(drift=drift, **ways)
    found = align(of_master, of_server)
    off_s = np.abs(found.to_server(sent) - server_clock(sent)) * 1e-9
    assert off_s.max() <= found.uncertainty_s + 1e-9
    assert found.uncertainty_s < 35e-3


def test_a_short_session_leaves_its_drift_open():
    long, short = (
        align(*conversation(seconds=seconds, jitter_ns=500_000)[:2]) for seconds in (40, 5)
    )
    assert short.uncertainty_s - long.uncertainty_s > 0.5e-3  # 500 ppm over half of 5 s
    assert short.rate == pytest.approx(0.0, abs=1e-9)


def test_what_an_emulated_link_delays_is_taken_off():
    of_master, of_server, sent, _ = conversation(link=24_000_000)
    told, untold = (
        align(of_master, of_server, *pair)
        for pair in ((fates(len(sent), 24_000_000),) * 2, (None, None))
    )
    assert told.uncertainty_s < 5e-3 < 20e-3 < untold.uncertainty_s


def test_without_echoes_nothing_is_claimed():
    assert align([], []) is None


def skewed(traces, shift_s):
    for user in traces.users:
        user.time_s = user.time_s + shift_s
        user.block_time_s = user.block_time_s + shift_s
    return traces


def test_what_the_alignment_leaves_open_is_no_violation_and_no_proof():
    """Clocks 20 ms apart on a 16 ms link: energy seems to come out before it went in."""
    traces = skewed(handmade.session(), 0.02)
    assert passivity(traces, handmade.scenario(), None).passive("user1") is False
    traces.metadata["alignment"] = {
        name: {"how": ECHO, "offset_s": 3600.0, "drift_ppm": 0.0, "uncertainty_s": 0.021}
        for name in ("user1", "user2")
    }
    found = passivity(traces, handmade.scenario(), None)
    assert found.passive("user1") is None
    assert "clocks" in found.of("user1")[0].why
    active = skewed(handmade.session(gain=1.2), 0.02)
    active.metadata["alignment"] = traces.metadata["alignment"]
    assert passivity(active, handmade.scenario(), None).passive("user1") is False


def test_a_clock_that_is_set_over_and_over_bends_no_time_line():
    monotonic = np.arange(1000, dtype=np.int64) * FRAME_NS
    stamps = monotonic + 10**18 + np.where(np.arange(1000) % 7 < 3, 10**10, 0)
    even = monotonic + clocks.offset_ns(monotonic, stamps)
    assert set(np.diff(even)) == {FRAME_NS}


@pytest.mark.parametrize("shift_s", [-1e4, -5.0, -0.05, 0.05, 5.0, 1e4])
def test_traces_on_other_time_lines_are_judged_without_a_crash(shift_s):
    traces = skewed(handmade.session(duration_s=1.6), shift_s)
    for each in itertools.chain(traces.packets.values()):
        each.time_s = each.time_s + shift_s
    result = summary(traces, handmade.scenario())
    assert result["verdict"]
