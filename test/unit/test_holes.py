# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Holes in the recording: nothing is judged there, and nothing is blamed on a node."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import handmade
from support.handmade import FRAME_S

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.events.events import complete
from pmwvc_analysis.traces.holes import holes
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_analysis.verdicts.verdicts import summary

BLOCKS = 250  # of two seconds
HOLES = st.lists(
    st.tuples(
        st.sampled_from(["user1", "user2", "server"]),
        st.integers(1, BLOCKS - 40),
        st.integers(1, 38),
    ),
    min_size=1,
    max_size=5,
)


def holed(cuts, *, gain=1.0):
    traces = handmade.session(duration_s=BLOCKS * FRAME_S, gain=gain)
    for owner, first, count in cuts:
        span = slice(first, first + count)
        if owner == "server":
            if first + count < len(traces.server.time_s):
                handmade.without_steps(traces.server, span)
        else:
            user = traces.users[int(owner[-1]) - 1]
            if first + count < len(user.block_time_s):
                handmade.without_blocks(user, span)
    return traces


@given(HOLES)
@settings(max_examples=25, deadline=None)
def test_a_hole_never_makes_an_active_session_passive(cuts):
    found = passivity(holed(cuts, gain=1.2), handmade.scenario(), None)
    for owner in ("user1", "user2"):
        assert found.passive(owner) is not True


@given(HOLES)
@settings(max_examples=8, deadline=None)
def test_a_session_with_holes_fails_the_check_and_names_them(cuts):
    traces, scenario = holed(cuts), handmade.scenario()
    result = summary(traces, scenario, budget(traces, scenario))
    assert result["check"]["passed"] is False
    assert result["recording"]["holes"]
    assert any("not recorded" in reason for reason in result["check"]["reasons"])
    assert any(line["ok"] is False for line in result["verdict"])
    assert not [event for event in result["events"] if event["kind"] == "stall"]
    assert {event["kind"] for event in result["events"]} >= {"recording"}


def test_a_hole_of_the_server_is_not_judged():
    traces = handmade.session(duration_s=BLOCKS * FRAME_S, gain=0.5)
    handmade.without_steps(traces.server, slice(200, 204))
    found = passivity(traces, handmade.scenario(), None)
    for port in found.of("user1"):
        assert port.passive is None and "server was not recorded" in port.why


def test_skipped_ticks_are_a_stall_and_no_hole():
    traces = handmade.session()
    user = traces.users[0]
    for values in (user.time_s[2000:], user.block_time_s[250:]):
        values += 0.3
    user.tick[2000:] += 300
    user.compute_s[:] = 520e-6
    assert holes(traces) == []
    (stall,) = [e for e in complete(traces, handmade.scenario()) if e["kind"] == "stall"]
    assert stall["who"] == "user1 master"
    assert "no ticks for 0.300 s" in stall["what"]
    found = summary(traces, handmade.scenario())
    judged, said = found["users"], [line["text"] for line in found["verdict"]]
    due = len(user.tick) + 300
    (slow,) = (text for text in said if text.startswith(f"user1: 300 of {due} ticks did not run"))
    assert slow.endswith("; a tick took 520 µs.")
    assert not any("ticks did not run" in text for text in said if text.startswith("user2"))
    assert [each["ticks_skipped"] for each in judged] == [300, 0]
    assert [each["ticks_missing"] for each in judged] == [0, 0]
    ran = len(user.tick) - 1
    assert judged[0]["tick_rate_hz"] == pytest.approx(ran / (user.time_s[-1] - user.time_s[0]))
    assert judged[1]["tick_rate_hz"] == pytest.approx(1000.0)


def test_a_start_that_was_not_recorded_is_a_hole():
    traces = handmade.session()
    handmade.without_blocks(traces.users[0], slice(0, 100))
    (hole,) = holes(traces)
    assert (hole.start_s, hole.end_s, hole.missing) == (0.0, pytest.approx(100 * FRAME_S), 100)


def test_stability_is_not_judged_where_its_window_is_missing():
    traces = handmade.session()
    for user in traces.users:
        handmade.without_blocks(user, slice(340, 480))  # 2.72 to 3.84 s of 4 s
    result = summary(traces, handmade.scenario())
    assert result["stable"] is None
    assert "too little of the motion" in result["stability"]["text"]
    whole = summary(handmade.session(), handmade.scenario())
    assert whole["stable"] is True


def test_an_oscillation_beside_a_hole_is_found_and_a_jump_across_it_is_none():
    wild = handmade.oscillating(handmade.session(), rms_m_s=0.02, hertz=9.0)
    handmade.without_blocks(wild.users[0], slice(400, 420))
    assert summary(wild, handmade.scenario())["stable"] is False
    calm = handmade.session()
    user = calm.users[0]
    user.xd_m[user.time_s > 3.3] += 0.5  # somewhere in the hole
    handmade.without_blocks(user, slice(400, 420))
    assert summary(calm, handmade.scenario())["stable"] is True
