# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Clocks of several hosts are aligned by the echoes of packets, never by wall time."""

from types import SimpleNamespace

import numpy as np
import pytest
from support import handmade
from support.rewriting import raw, rewritten

from pmwvc_analysis.recording.clocks import ECHO, ONE_HOST, align
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.traces import FateTraces

FRAME_NS = 8_000_000
THETA_NS = 3_600_000_000_000 + 123_456  # hosts started an hour apart
MS = 1_000_000


class Conversation:
    """Packets both ways: what each end sends, with the echoes of what it got before. ``link_ns``
    is the delay of an emulated link each way, told by its ``fates``.
    """

    def __init__(
        self, *, theta_ns=THETA_NS, drift=0.0, up_ns=300_000, down_ns=300_000, jitter_ns=0,
        seconds=40, link_ns=0,
    ):  # fmt: skip
        random = np.random.default_rng(7)
        count = seconds * 1_000_000_000 // FRAME_NS
        self.sent = np.arange(count, dtype=np.int64) * FRAME_NS + 5_000_000_000
        self.theta_ns, self.drift = theta_ns, drift
        back = self.sent + 2 * MS  # the server steps 2 ms after the masters send
        late = random.integers(0, jitter_ns + 1, (2, count))
        came = self.sent + up_ns + link_ns + late[0], back + down_ns + link_ns + late[1]
        self.of_server = self._echoes(back, self.sent, came[0], self.on_server, np.asarray)
        self.of_master = self._echoes(self.sent, back, came[1], np.asarray, self.on_server)
        numbers, zeros = np.arange(1, count + 1), np.zeros(count, dtype=np.int64)
        times = (zeros + 1000, zeros + 1000 + link_ns, zeros + 1000 + link_ns)
        epochs = np.ones(count, dtype=np.uint64)
        self.fates = FateTraces("user1/up", numbers, epochs, numbers, zeros, *times, zeros, zeros)

    def on_server(self, master_ns):
        drifted = np.round(self.drift * (master_ns - self.sent[0])).astype(np.int64)
        return master_ns + self.theta_ns + drifted

    def _echoes(self, own, peer, came, here, there):
        newest = np.searchsorted(came, own, "right") - 1
        return [
            SimpleNamespace(
                sent_ns=int(here(at)),
                echo_seq=int(row) + 1,
                echo_sent_ns=int(there(peer[row])),
                echo_hold_ns=int(here(at) - here(came[row])),
            )
            for at, row in zip(own, newest, strict=True)
            if row >= 0
        ]

    def aligned(self, *fates):
        """Return the alignment, and the largest error of the server's times [s]."""
        found = align(self.of_master, self.of_server, *fates)
        off_ns = np.abs(found.to_server(self.sent) - self.on_server(self.sent))
        return found, float(off_ns.max()) * 1e-9


def test_one_host_needs_no_alignment_and_without_echoes_nothing_is_claimed():
    found, off_s = Conversation(theta_ns=0, jitter_ns=3 * MS).aligned()
    assert (found.how, off_s) == (ONE_HOST, 0.0)
    assert align([], []) is None


@pytest.mark.parametrize(
    ("path", "least_s", "most_s"),
    [
        ({}, 0.0, 5e-3),
        ({"jitter_ns": 5 * MS}, 0.0, 5e-3),
        ({"up_ns": 9 * MS, "down_ns": 200_000}, 3e-3, 1.0),  # what is not symmetric stays open
        ({"drift": 50e-6, "seconds": 60}, 0.0, 1e-3),  # without it: 3 ms
        ({"drift": -100e-6, "seconds": 60}, 0.0, 1e-3),
    ],
)
def test_two_hosts_are_aligned_within_the_reported_uncertainty(path, least_s, most_s):
    found, off_s = Conversation(**path).aligned()
    assert found.how == ECHO
    assert least_s <= off_s <= min(most_s, found.uncertainty_s + 1e-9)
    assert found.uncertainty_s < 6e-3
    assert found.rate == pytest.approx(path.get("drift", 0.0), rel=0.05, abs=1e-6)


@pytest.mark.parametrize("last", [500, 2500])
@pytest.mark.parametrize("drift", [-100e-6, 100e-6])
def test_a_path_whose_ways_change_places_stays_within_the_reported_uncertainty(last, drift):
    """No line fits all of it; that of the last windows leaves the drift open before them."""
    up_ns = np.where(np.arange(5000) < 5000 - last, 20 * MS, 300_000)
    found, off_s = Conversation(drift=drift, up_ns=up_ns, down_ns=20_300_000 - up_ns).aligned()
    assert off_s <= found.uncertainty_s + 1e-9
    assert found.uncertainty_s < 35e-3


def test_a_short_session_leaves_its_drift_open():
    long, short = (
        Conversation(seconds=seconds, jitter_ns=500_000).aligned()[0] for seconds in (40, 5)
    )
    assert short.uncertainty_s - long.uncertainty_s > 0.5e-3  # 500 ppm over half of 5 s
    assert short.rate == pytest.approx(0.0, abs=1e-9)


def test_what_an_emulated_link_delays_is_taken_off():
    heard = Conversation(link_ns=24 * MS)
    told, untold = heard.aligned(heard.fates, heard.fates)[0], heard.aligned()[0]
    assert told.uncertainty_s < 5e-3 < 20e-3 < untold.uncertainty_s


def skewed(traces, shift_s):
    for each in (*traces.users, *traces.packets.values()):
        each.time_s = each.time_s + shift_s
    for user in traces.users:
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


HOUR_NS = 3_600_000_000_000


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A recording of one second."""
    place, scenario = tmp_path_factory.mktemp("session"), handmade.scenario(duration_s=1.0)
    record_traces(place, handmade.session(duration_s=1.0), scenario, start_ns=handmade.START_NS)
    return place


def clocks(wall_ns=lambda seq: 0, host_ns=0, *, echoes=True):
    """Change the clocks of user1's host: wall time per block, and time since its start."""

    def change(topic, message):
        up, down = topic.endswith("user1/wave_up"), topic.endswith("user1/wave_down")
        if topic == "/user1/trace":
            stamp_ns = nanoseconds(message.stamp) + wall_ns(message.seq)
            message.stamp.sec, message.stamp.nanosec = divmod(stamp_ns, 10**9)
            message.start_ns += host_ns
        elif (up or down) and echoes:
            if message.seq > 2:  # the newest that had come is two frames old, 16 ms
                message.echo_seq = message.seq - 2
                message.echo_sent_ns = message.sent_ns - 16_000_000 + (host_ns if down else 0)
            message.sent_ns += host_ns if up else 0
        return message

    return change


@pytest.mark.parametrize(
    "change",
    [
        clocks(wall_ns=lambda seq: 50_000_000, host_ns=HOUR_NS),
        clocks(wall_ns=lambda seq: 24 * HOUR_NS * (seq % 3), host_ns=-HOUR_NS),
    ],
)
def test_wall_clocks_that_differ_make_no_link_active(folder, tmp_path, change):
    found = read_session(rewritten(raw(folder), tmp_path / "b", change))
    for left, right in zip(read_session(folder).users, found.users, strict=True):
        np.testing.assert_allclose(right.time_s, left.time_s, atol=1e-6)
    assert passivity(found, handmade.scenario(duration_s=1.0), None).passive("user1") is True


def test_without_echoes_only_a_wall_clock_aligns_and_that_is_reported(folder, tmp_path):
    ahead = clocks(wall_ns=lambda seq: 50_000_000, echoes=False)
    found = read_session(rewritten(raw(folder), tmp_path / "b", ahead))
    assert found.metadata["alignment"]["user1"]["how"] == "wall clock"
    np.testing.assert_allclose(found.users[0].time_s[0] - found.users[1].time_s[0], 0.05)
