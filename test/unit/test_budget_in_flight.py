# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget of a session in which the wave impedance changed while it ran."""

import dataclasses

import numpy as np
import pytest
from support import plain as scenarios

from pmwvc_analysis.budget.budget import budget
from pmwvc_core.simulation.session import SteppedSession

CHANGE_NS, TICK_S = 3_000_000_000, 0.001


@pytest.mark.parametrize("impedance", [0.01, 100.0, 1000.0])
def test_to_the_safety_limits_goes_what_limited_ticks_took_and_nothing_else(impedance):
    scenario = scenarios.load("carry_16ms", duration_s=5.0)
    session = SteppedSession(scenario)
    session.advance(CHANGE_NS)  # up to a frame start
    master = dataclasses.replace(scenario.users[0].master, impedance=impedance)
    session.users[0].loop.configure(master=master)
    session.run(lambda _: None)
    traces = session.traces()
    user = traces.users[0]
    power = (user.f_applied * user.xd_m)[:, 0] - (user.u_m**2 - user.v_m**2)[:, 0] / 2
    booked = budget(traces, scenario).parts["user1"]["safety"]
    assert booked[-1] == pytest.approx(np.sum(power) * TICK_S, abs=1e-6)
    assert 0.0 < np.abs(booked).max() < 0.1  # [J] of a grip that holds 2 mJ: no 1e281
    quiet = np.abs(user.f_applied - user.f_m)[:, 0] <= 1e-9
    before = slice(0, int(CHANGE_NS / 1e6))
    assert np.abs(power[before][quiet[before]]).max() < 1e-12
