# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An end is named with its time, the session is judged up to there, and the check fails."""

import numpy as np
import pytest
from support import handmade
from support import plain as scenarios
from support.handmade import FORCE_N

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.events.events import complete
from pmwvc_analysis.traces.stages import until
from pmwvc_analysis.verdicts.endings import endings
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.simulation.session import simulate_one

KILLED = "was ended by SIGKILL"


def judged(traces):
    return summary(traces, handmade.scenario())


def noted(who, time_s):
    return {"time_s": time_s, "who": who, "what": KILLED, "code": -9, "signal": "SIGKILL"}


@pytest.mark.parametrize("texts", [["link.schedule=1.5 outage"], ["master.rate_drop=900"]])
def test_neither_an_outage_nor_a_slow_sender_ends_an_emulator(texts):
    scenario = scenarios.load("carry_16ms", settings_texts=texts, duration_s=3.0)
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
    traces.events = [{"time_s": 2.4, "who": "user2 master", "what": "exited with 0", "code": 0}]
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


@pytest.mark.parametrize("spoil", ["nothing", "active", "unstable"])
def test_the_check_is_the_verdict(spoil):
    traces = handmade.session(gain=1.2 if spoil == "active" else 1.0)
    if spoil == "unstable":
        handmade.oscillating(traces, rms_m_s=0.02, hertz=9.0)
    result = judged(traces)
    assert result["check"]["passed"] is (spoil == "nothing")
    assert all(line["ok"] for line in result["verdict"]) is (spoil == "nothing")
