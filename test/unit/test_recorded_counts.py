# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The counts and sums of a whole session: in its recording, its budget, its summary."""

import numpy as np
from support import handmade

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_session


def test_ticks_missed_and_interventions_of_the_limits_are_read_as_they_were_recorded(tmp_path):
    traces = handmade.session(duration_s=0.5)
    for number, user in enumerate(traces.users):
        user.missed, user.safety_events = 7 + number, 3 + number
    record_traces(tmp_path, traces, handmade.scenario(duration_s=0.5))
    again = read_session(tmp_path)
    assert [user.missed for user in again.users] == [user.missed for user in traces.users]
    found = [int(user.safety_events) for user in again.users]
    assert found == [user.safety_events for user in traces.users]


def test_the_budget_says_once_where_a_server_that_started_twice_again_ends_it():
    traces = handmade.session(duration_s=0.5)
    steps = len(traces.server.step)
    traces.server.step = np.arange(steps) % (steps // 3)
    notes = [
        note
        for note in budget(traces, handmade.scenario(duration_s=0.5)).notes
        if "started" in note
    ]
    when_s = traces.server.time_s[steps // 3]
    assert notes == [f"server: it was started again at {when_s:.2f} s; the budget ends there"]


def test_the_energies_of_a_summary_are_those_of_the_last_step():
    traces = handmade.session(duration_s=0.5)
    found = budget(traces, handmade.scenario(duration_s=0.5))
    found.hands["user1"][-1] += 0.25
    named = {each["name"]: each["hand_j"] for each in found.summary()["users"]}
    assert named == {name: sums[-1] for name, sums in found.hands.items()}
    assert found.summary()["residual_j"] == found.residual_j[-1]
