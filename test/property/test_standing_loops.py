# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A master whose loop stands still while its hand moves: what the force that stays on gives."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st
from support.verdicts import given_while_still_j

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import scenarios as files
from pmwvc_core.frame import LIVE
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import simulate_one

TICKS = 3000


def stalled(stalls, *more):
    """Return a session in which a hand pushes and lets go; its loop skips ticks from some on."""
    texts = ["channel=strict", "link.delay_s=0.004", "operator.damping=3", *more]
    texts += ["master.store_j=0", "server.store_j=0"]
    scenario = files.load("wall", settings_texts=texts, duration_s=TICKS / 1000)
    ran_ns = np.arange(TICKS, dtype=np.int64) * 1_000_000
    for start, ticks in stalls:
        ran_ns[start : start + ticks] = -1
    with pytest.MonkeyPatch.context() as patch:  # the hand is not asked to fill a store
        patch.setattr("pmwvc_core.made.user.TANK_J", 0.0)
        traces = simulate_one(scenario, Conditions(schedule=LIVE, ran_ns={"user1": ran_ns}))
    (user,) = traces.users  # blocks have numbers on a recording: none is missing
    numbers = 1 + np.arange(len(user.block_time_s))
    return scenario, replace(traces, users=[replace(user, block_number=numbers)])


def judged(scenario, traces):
    return summary(traces, scenario, budget(traces, scenario))


@example(stalls=[(2100, 100)])
@settings(max_examples=5, phases=(Phase.explicit, Phase.generate))
@given(
    stalls=st.lists(
        st.tuples(st.integers(1900, 2500), st.sampled_from([30, 50, 100, 200, 500])),
        min_size=1,
        max_size=3,
    )
)
def test_what_a_standing_loop_gives_away_is_named_and_no_missed_prediction(stalls):
    scenario, traces = stalled(stalls)
    found = judged(scenario, traces)
    passivity = found["passivity"]
    violated = [port for port in passivity["ports"] if port["passive"] is False]
    assert {port["part"] for port in violated} <= {"hand_port"}
    for entry in violated:
        assert entry["held_j"] > 0.0 and "stood still" in entry["why"]
    (said,) = [each for each in found["outcomes"] if each["what"] == "passivity"]
    assert said["hit"] is (None if violated else True)


def test_the_force_that_stays_on_is_what_goes_beyond():
    """A grip that gives way in a stall; the controls: no stall, and a leak of another origin."""
    scenario, traces = stalled([(2100, 100)])
    still_j = given_while_still_j(traces.users[0])
    assert still_j > 5e-4
    found = judged(scenario, traces)
    (port,) = [each for each in found["passivity"]["ports"] if each["passive"] is False]
    # in the rest of the block the device came back some of the way
    assert 0.3 * still_j < port["held_j"] <= still_j
    _, calm = stalled([])
    assert judged(scenario, calm)["passivity"]["components"] == []
    (user,) = calm.users
    user.energy["device"][user.block_time_s > 2.4] -= 5e-3
    (port,) = [
        each for each in judged(scenario, calm)["passivity"]["ports"]
        if each["part"] == "hand_port"
    ]  # fmt: skip
    assert port["passive"] is False
    assert port["held_j"] == 0.0 and port["why"] == ""


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_the_budget_closes_beside_the_ticks_that_a_loop_skipped(channel):
    scenario, traces = stalled(
        [(2100, 100), (2400, 30)], f"channel={channel}", "device.damping=0.5"
    )
    found = budget(traces, scenario)
    assert found.closes and found.notes == []
    assert ("user1", "sample_hold") in found.remainders  # damper and hold went on
    (user,) = traces.users
    user.energy["hand"][user.block_time_s > 1.2] += 1e-8  # the control: work that was not done
    assert not budget(traces, scenario).closes
