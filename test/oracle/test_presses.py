# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Slow presses on a stiff wall: what they take from the loan of the position feedback."""

import math

import numpy as np
import pytest
from presses import DELAY_S, GAP_M, Presses, pressed, scenario_of, simulated
from support.laws import alter_laws

TAU_S = 2.0 * DELAY_S + 0.008 + 0.0035  # a step, and the ramp of eight ticks
PRESS_S = 2.0
LOAN_J = 1.5e-3
LENT = ("master.position.adapts=true", f"master.position.storage_j={LOAN_J}")


@pytest.mark.parametrize("stiffness", [700.0, 2000.0])
def test_slow_presses_take_from_the_loan_where_the_wall_is_stiffer_than_the_gain(stiffness):
    """On a softer wall they give back. Equation: docs/theory.md 17.17."""
    gain = 1000.0 / math.sqrt(2.0 * 25.0)
    lent = (f"master.position.gain={gain}", "master.position.storage_j=0.02")
    run = Presses(stiffness, settings=lent)
    scenario = scenario_of(run, 11.0)
    assert scenario.users[0].master.impedance == 25.0
    # into the wall in 2 s, then three presses in lasting contact
    time_s, press_s = np.arange(10500) * 1e-3, 2.5
    least_m, more_m = GAP_M + 0.3 / 375.0, 1.5 / 375.0
    into = np.clip(time_s / 2.0, 0.0, 1.0)
    motion = least_m * into**2 * (3.0 - 2.0 * into)
    phase = 2.0 * np.pi * np.clip((time_s - 2.5) / press_s, 0.0, 3.0)
    motion += 0.5 * more_m * (1.0 - np.cos(phase))
    traces = simulated(scenario, motion)
    (user,) = traces.users
    first_s = user.time_s[np.flatnonzero(user.f_h[:, 0])[0]]
    ends_s = first_s + 2.5 + press_s * np.array([2.0, 3.0]) + 0.1
    left = np.interp(ends_s, user.block_time_s, user.accounts["node"])
    speed = 0.5 * more_m * 2.0 * np.pi / press_s * 375.0 / (375.0 + stiffness)
    taken_j = stiffness * TAU_S * (stiffness / 1000.0 - 1.0) * 0.5 * speed**2 * press_s
    assert left[0] - left[1] == pytest.approx(taken_j, rel=0.1)


def test_presses_leave_the_loan_at_a_level_above_zero(monkeypatch):
    run = Presses(1000.0, press_s=PRESS_S, settings=LENT)
    found = pressed(run, 10.5 * PRESS_S)
    taken = -np.diff(found.left_j)
    assert taken[0] > 2e-5  # with the gain itself a press takes this much, every time
    assert taken[-1] < 0.25 * taken[0]
    assert found.left_j[-1] > 0.5 * LOAN_J
    assert found.felt_n_m[-1] == pytest.approx(1000.0, rel=0.05)
    assert found.passive
    assert -LOAN_J <= found.least_j < -1e-4
    # the control: the same gain whatever is left
    alter_laws(monkeypatch, position__feedback__MOST=1.0)
    control = pressed(run, 10.5 * PRESS_S)
    assert -np.diff(control.left_j)[-1] > 2.0 * taken[-1]
    assert control.left_j[-1] < found.left_j[-1] - 2e-4
    assert control.passive
