# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions with a deadband, and with rates that change, as report, record and replay show them."""

import pytest
from support import plain as files
from support.rewriting import unequal

from pmwvc_analysis.compare.measures import measures
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_analysis.replay.run import exact, replay
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.errors import ScenarioError
from pmwvc_core.simulation.session import simulate_one

WEBER = ("master.deadband.kind=weber", "server.deadband.kind=weber")


def strict(*texts, duration_s=3.5):
    texts = ("channel=strict", "task.grip_s=0.2", "safety.soft_start_s=0.1", *texts)
    return files.load("carry_16ms", settings_texts=texts, duration_s=duration_s)


def offset_m(traces):
    """Distance of the first device from its avatar at the end."""
    return abs(traces.users[0].x_m[-1, 0] - traces.server.x_s[0][-1, 0])


def test_what_was_left_out_and_what_it_costs_is_reported():
    with_ = strict(*WEBER, duration_s=7.0)  # by then the lag of the first waits is caught up
    without = strict()
    traces, other = simulate_one(with_), simulate_one(without)
    found = summary(traces, with_)
    for each in found["receptions"]:
        assert 0.5 < each["left_out"] < 0.67  # at most two of three: 24 ms are three frames
        assert each["counts"]["lost"] == 0
    offsets = [each for each in found["outcomes"] if each["what"] == "offset"]
    assert [each["hit"] for each in offsets] == [None, None]
    assert "left out or skipped" in offsets[0]["text"]
    assert 0.5 < measures(traces, with_)["left_out"] < 0.67
    assert measures(other, without)["left_out"] is None
    even = float(offsets[0]["text"].split("expected")[1].split("mm")[0])
    assert even == pytest.approx(offset_m(traces) * 1e3, abs=0.1)
    # 16 ms later each way: F 32 ms/(2b) more, here at 1.5 N.
    assert offset_m(traces) - offset_m(other) == pytest.approx(1.5 * 0.032 / 50.0, rel=0.35)


def test_a_session_with_a_deadband_is_recorded_checked_and_replayed(tmp_path):
    scenario = strict(*WEBER, duration_s=2.0)
    traces = simulate_one(scenario)
    record_traces(tmp_path, traces, scenario)
    again, known = read_session(tmp_path), read_scenario(tmp_path)
    assert inconsistencies(traces, scenario) == inconsistencies(again, known) == []
    assert list(unequal(traces.packets, again.packets)) == []
    assert exact(replay(again, known, known).differences)


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        (
            ("channel=plain", WEBER[0]),
            "user1.master.deadband.kind = weber: needs channel = strict",
        ),
        (
            (WEBER[1], "server.deadband.longest_s=0.05", "safety.timeout_s=0.04"),
            "must be < safety",
        ),
        (
            ("changes=1 server.period_s=0.02", "server.coupling=one_frame_late"),
            "avatars move by the velocity of the step before",
        ),
    ],
)
def test_what_the_channel_cannot_carry_is_refused_with_the_reason(texts, words):
    with pytest.raises(ScenarioError, match=words):
        strict(*texts)
