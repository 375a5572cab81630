# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Ends of sessions are named with their time, and the session is judged up to there; the check
asks that users are coupled and have their force but for what the scenario takes away.
"""

import numpy as np
import pytest
from support import handmade
from support import plain as files
from support.handmade import FORCE_N

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.events.events import complete
from pmwvc_analysis.traces.stages import until
from pmwvc_analysis.verdicts.endings import endings
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import scenarios
from pmwvc_core.frame import Presence
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.network.in_flight import Cause
from pmwvc_core.simulation.session import simulate_one

DURATION_S = 10.0


def disturbed(start_s, end_s, *, at_server=False):
    """A press of ten seconds in which nobody is coupled from a time to another."""
    traces = handmade.session(duration_s=DURATION_S)
    for user in traces.users:
        rows = (user.block_time_s > start_s) & (user.block_time_s <= end_s)
        user.state[rows & (not at_server)] = SafetyState.DAMPING
    server = traces.server
    for state in server.state:
        state[(server.time_s >= start_s) & (server.time_s < end_s) & at_server] = Presence.DAMPING
    return traces


def checked(traces, **overrides):
    return summary(traces, handmade.scenario(duration_s=DURATION_S, **overrides))["check"]


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_a_session_in_which_nothing_ever_arrived_is_not_judged_and_does_not_pass(channel):
    texts = [f"channel={channel}", "link.loss=1"]
    scenario = scenarios.load("carry_16ms", settings_texts=texts, duration_s=4.0)
    found = summary(simulate_one(scenario), scenario)
    assert found["stable"] is None
    assert "Predicted stable: it was." not in [each["text"] for each in found["outcomes"]]
    assert not found["check"]["passed"]
    assert "user1: never coupled." in found["check"]["reasons"]


@pytest.mark.parametrize("at_server", [False, True])
def test_a_break_of_the_coupling_does_not_pass_and_one_that_no_hand_notices_does(at_server):
    found = checked(disturbed(4.0, 4.4, at_server=at_server))
    assert found["reasons"][0].startswith("user1: not coupled, or with less than half of its 1.00")
    assert found["reasons"][0].endswith("for 0.40 s.")
    assert checked(disturbed(4.0, 4.08, at_server=at_server))["passed"]
    assert checked(disturbed(0.0, 1.0, at_server=at_server))["passed"]  # the session starts


def test_an_outage_that_the_scenario_asks_for_is_none_of_the_sessions():
    traces = disturbed(4.0, 6.5)
    lost = traces.fates["user1/up"]
    outage = (lost.time_in_ns >= 4e9) & (lost.time_in_ns < 6e9)
    lost.cause[outage] = Cause.OUTAGE
    assert checked(traces)["passed"]
    lost.cause[outage] = Cause.LOSS
    assert not checked(traces)["passed"]


def killed(start_s, end_s, who="server"):
    traces = disturbed(start_s, end_s)
    traces.events = [
        {"time_s": time_s, "who": who, "kind": "disturbance", "what": f"as asked: {action}"}
        for time_s, action in ((start_s, "stop"), (end_s, "continue"))
    ]
    return traces


def test_a_server_that_the_scenario_kills_for_a_while_passes_and_one_dead_most_of_the_time_not():
    assert checked(killed(4.0, 6.0))["passed"]
    assert not checked(disturbed(4.0, 6.0))["passed"]  # nobody asked for it
    found = checked(killed(3.0, 9.0))
    assert found["reasons"] == [
        f"{who}: coupled for 40% of the time." for who in ("user1", "user2")
    ]


def test_a_blow_and_a_force_that_is_missing_do_not_pass():
    traces = disturbed(0.0, 0.0)
    user = traces.users[1]
    user.f_applied[(user.time_s > 4.9995) & (user.time_s < 5.1995)] *= 0.1
    assert checked(traces)["reasons"] == [
        "user2: not coupled, or with less than half of its 1.00 N, for 0.20 s; the force changed "
        "by 0.90 N within 1 ms at 5.00 s and 1 more above 0.3 N."
    ]
    faded = 1.0 - 0.9 * np.clip(1.0 - np.abs(user.time_s - 5.0) / 0.05, 0.0, 1.0)
    user.f_applied = user.f_m * faded[:, np.newaxis]  # for 56 ms
    assert checked(traces)["passed"]


def test_an_emulator_that_the_scenario_stops_runs_again_with_the_first_packet_it_relays():
    traces = killed(4.0, 5.0, "netem")
    for user in traces.users:
        user.state[(user.block_time_s > 5.0) & (user.block_time_s < 7.5)] = SafetyState.DAMPING
    assert not checked(traces)["passed"]
    for name in ("user1", "user2"):
        came = traces.packets[f"/server/{name}/wave_up"]
        came.time_s[came.time_s > 4.0] = np.maximum(came.time_s[came.time_s > 4.0], 6.5)
    assert checked(traces)["passed"]


KILLED = "was ended by SIGKILL"


def judged(traces):
    return summary(traces, handmade.scenario())


def noted(who, time_s):
    end = {"what": KILLED, "code": -9, "signal": "SIGKILL"}
    return {"time_s": time_s, "who": who, "kind": "ended", **end}


@pytest.mark.parametrize("texts", [["link.schedule=1.5 outage"], ["master.rate_drop=900"]])
def test_neither_an_outage_nor_a_slow_sender_ends_an_emulator(texts):
    scenario = files.load("carry_16ms", settings_texts=texts, duration_s=3.0)
    traces = simulate_one(scenario)
    assert endings(traces, complete(traces, scenario), scenario) == []


@pytest.mark.parametrize("who", ["server", "netem"])
def test_a_session_whose_server_or_emulator_died_is_judged_up_to_there(who):
    traces = handmade.session()
    for user in traces.users:  # what the safety limits make of it
        user.f_applied[user.time_s > 2.6] = 0.0
        user.f_m[user.time_s > 2.6] = 0.0
    traces.events = [noted(who, 2.5)]
    result = judged(traces)
    assert result["interrupted"] == [f"{who} {KILLED} at 2.50 s"]
    assert result["judged_until_s"] == 2.5
    assert result["users"][0]["force_final_n"] == pytest.approx(FORCE_N)  # not 0.00 N
    assert result["verdict"][0]["text"].startswith("Stable until 2.50 s")
    assert result["check"]["passed"] is False


def test_a_server_whose_trace_breaks_off_has_ended():
    traces = handmade.session()
    handmade.without_steps(traces.server, slice(300, None))
    for topic in ("/server/user1/wave_down", "/server/user2/wave_down"):
        del traces.packets[topic]
    result = judged(traces)
    assert result["interrupted"] == ["server was last recorded at 2.40 s"]
    assert result["judged_until_s"] == pytest.approx(2.4)


def test_a_master_that_died_ends_its_user_and_the_other_goes_on():
    traces = handmade.session()
    handmade.without_blocks(traces.users[1], slice(250, None))
    traces.server.state[1][traces.server.time_s > 2.1] = 3  # the server damps its avatar
    traces.events = [noted("user2 master", 2.0)]
    result = judged(traces)
    assert result["judged_until_s"] == result["duration_s"]
    assert result["interrupted"] == [f"user2 master {KILLED} at 2.00 s"]
    first, second = result["users"]
    assert first["ended"] is None
    assert second["ended"] == f"user2 master {KILLED} at 2.00 s"
    assert result["check"]["passed"] is False
    asked = {"who": "user2 master", "kind": "disturbance", "what": "as the scenario asks: kill"}
    traces.events.append(asked | {"time_s": 1.99})
    result = judged(traces)
    assert result["interrupted"] == []
    assert result["users"][1]["ended"] == "user2 master was killed, as asked, at 2.00 s"


def test_a_user_who_left_is_no_interruption():
    traces = handmade.session()
    handmade.without_blocks(traces.users[1], slice(250, None))
    traces.server.state[1][traces.server.time_s > 2.01] = 0
    traces.server.contact[1][traces.server.time_s > 2.01] = False
    handmade.without_blocks(traces.users[1], slice(20, 24))  # not recorded
    ended = {"kind": "ended", "what": "exited with 0", "code": 0}
    traces.events = [{"time_s": 2.4, "who": "user2 master", **ended}]
    result = judged(traces)
    assert result["interrupted"] == []
    assert result["users"][1]["ended"] == "user2 left at 2.00 s"
    assert result["stable"] is True, result["stability"]["text"]  # judged as long as it was there
    assert "leave" in {event["kind"] for event in result["events"]}


def test_another_publisher_is_named_and_fails_the_check():
    traces = handmade.session()
    what = "800 messages on /server/trace from another publisher, left out"
    traces.events = [{"time_s": 1.0, "who": "/server/trace", "kind": "stranger", "what": what}]
    result = judged(traces)
    assert result["strangers"] == [what]
    assert result["check"]["reasons"] == [f"Another publisher: {what}."]


def test_what_is_cut_off_is_the_session_that_ended_then():
    whole, short = handmade.session(), handmade.session(duration_s=2.0)
    part = until(whole, 2.0)
    for user, expected in zip(part.users, short.users, strict=True):
        np.testing.assert_array_equal(user.tick, expected.tick)
        np.testing.assert_allclose(user.energy["u_m"], expected.energy["u_m"], atol=1e-15)
    np.testing.assert_array_equal(part.server.step, short.server.step)
    assert until(whole, 99.0) is whole


def test_the_budget_of_what_was_before_the_end_closes():
    scenario = handmade.scenario(server__contact="grip", duration_s=3.0)
    part = until(simulate_one(scenario), 2.0)
    assert budget(part, scenario).closes


@pytest.mark.parametrize(("actions", "passes"), [
    (("kill", "start"), True), (("stop", "continue"), False),
])  # fmt: skip
def test_the_hand_of_a_master_that_is_started_again_has_to_close_again(actions, passes):
    """For longer than a coupling takes; the hand of one that only stood still has not opened."""
    traces = killed(4.0, 4.5, "user2 master")
    for event, action in zip(traces.events, actions, strict=True):
        event["what"] = f"as asked: {action}"
    for user in traces.users:
        user.f_applied[(user.time_s > 4.0) & (user.time_s < 7.5)] *= 0.1
        user.f_applied[(user.time_s > 7.5) & (user.time_s < 7.6)] *= 0.5
    closing = {"task__kind": "hold", "task__grip_s": 1.0, "task__grip_rise_s": 1.0}
    reasons = checked(traces, **closing)["reasons"]
    assert any("less than half" in each for each in reasons) is not passes
