# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings of several machines: their clocks brought to one time line."""

import numpy as np
import pytest
from support import handmade
from support.handmade import START_NS
from support.rewriting import raw, rewritten

from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_core.runtime.messages import nanoseconds


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A recording of one second."""
    place = tmp_path_factory.mktemp("session")
    traces = handmade.session(duration_s=1.0)
    record_traces(place, traces, handmade.scenario(duration_s=1.0), start_ns=START_NS)
    return place


@pytest.mark.parametrize(("seconds", "blocks"), [(3600, range(101, 126)), (-3600, range(5, 9))])
def test_a_clock_that_is_set_does_not_bend_the_time_line(folder, tmp_path, seconds, blocks):
    def stepped(topic, message):
        if topic == "/user1/trace" and message.seq in blocks:
            message.stamp.sec += seconds
        return message

    found = read_session(rewritten(raw(folder), tmp_path / "b", stepped))
    np.testing.assert_allclose(found.users[0].time_s, np.arange(1000) * 0.001, atol=1e-6)
    assert found.server.time_s[0] == pytest.approx(0.0, abs=1e-6)


HOUR_NS = 3_600_000_000_000


def clocks(wall_ns=lambda seq: 0, host_ns=0):
    """Change the clocks of user1's host: wall time per block, and time since its start."""
    frame_ns, delay_ns = round(handmade.FRAME_S * 1e9), 16_000_000

    def change(topic, message):
        up, down = topic.endswith("user1/wave_up"), topic.endswith("user1/wave_down")
        if topic == "/user1/trace":
            stamp_ns = nanoseconds(message.stamp) + wall_ns(message.seq)
            message.stamp.sec, message.stamp.nanosec = divmod(stamp_ns, 10**9)
            message.start_ns += host_ns
        elif up or down:
            if message.seq > 2:  # the newest that had come is two frames old
                message.echo_seq = message.seq - 2
                message.echo_sent_ns = message.sent_ns - delay_ns + (host_ns if down else 0)
            message.sent_ns += host_ns if up else 0
        assert frame_ns * handmade.DELAY_FRAMES == delay_ns
        return message

    return change


@pytest.mark.parametrize(
    "change",
    [
        clocks(wall_ns=lambda seq: 50_000_000),
        clocks(wall_ns=lambda seq: 10_000_000_000 * (seq % 2)),
        clocks(wall_ns=lambda seq: 50_000_000, host_ns=HOUR_NS),
        clocks(wall_ns=lambda seq: 86_400_000_000_000 * (seq % 3), host_ns=-HOUR_NS),
    ],
    ids=["50 ms", "strobing", "another host", "another host, strobing"],
)
def test_wall_clocks_that_differ_make_no_link_active(folder, tmp_path, change):
    expected = read_session(folder)
    found = read_session(rewritten(raw(folder), tmp_path / "b", change))
    for left, right in zip(expected.users, found.users, strict=True):
        np.testing.assert_allclose(right.time_s, left.time_s, atol=1e-6)
    scenario = handmade.scenario(duration_s=1.0)
    assert passivity(found, scenario, None).passive("user1") is True


def test_without_echoes_only_a_wall_clock_aligns_and_that_is_reported(folder, tmp_path):
    def ahead(topic, message):
        if topic == "/user1/trace":
            message.stamp.nanosec += 50_000_000
        return message

    found = read_session(rewritten(raw(folder), tmp_path / "b", ahead))
    assert found.metadata["alignment"]["user1"]["how"] == "wall clock"
    np.testing.assert_allclose(found.users[0].time_s[0] - found.users[1].time_s[0], 0.05)
