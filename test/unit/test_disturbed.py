# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The check asks that users are coupled and have their force, all the time but what the scenario
takes away.
"""

import numpy as np
import pytest
from support import handmade
from support.simulated import quick_summary

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
    return quick_summary(traces, handmade.scenario(duration_s=DURATION_S, **overrides))["check"]


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_a_session_in_which_nothing_ever_arrived_is_not_judged_and_does_not_pass(channel):
    texts = [f"channel={channel}", "link.loss=1"]
    scenario = scenarios.load("carry_16ms", settings_texts=texts, duration_s=4.0)
    found = quick_summary(simulate_one(scenario), scenario)
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
