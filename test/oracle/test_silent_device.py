# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A device that brings no samples in a contact: what the hand moved meanwhile is undelivered, and
repaid by the moving hand.
"""

import functools

import numpy as np
import pytest
from support.simulated import least_j

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_bringup import scenarios as files
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.simulation.session import SteppedSession

LEAST_J = -1e-9
SILENT_S = 0.3


@functools.lru_cache
def carry(begin_s, *settings, duration_s=7.5):
    """Return scenario and traces of a carry whose first device is silent from then on for 0.3 s;
    never, where that is None.
    """
    scenario = files.load("carry_16ms", settings_texts=list(settings), duration_s=duration_s)
    batch = SteppedSession(scenario)
    sample = batch.users[0].device.sample
    for at_s, valid in ((begin_s, False), (begin_s and begin_s + SILENT_S, True)):
        if at_s is not None:
            batch.advance(round(at_s * 1e9))
            sample.valid = valid
    batch.run(lambda _: None)
    return scenario, batch.traces()


def apart_m(traces, at_s):
    """Distance of the first device from its avatar, largest within a tenth of a second [m]."""
    server, user = traces.server, traces.users[0]
    rows = (server.time_s >= at_s) & (server.time_s < at_s + 0.1)
    x_m = np.interp(server.time_s[rows], user.time_s, user.x_m[:, 0])
    return float(np.abs(x_m - server.x_s[0][rows, 0]).max())


def test_a_hand_that_moves_has_its_avatar_back_three_seconds_later():
    begin_s = 4.0
    scenario, traces = carry(begin_s)
    _, calm = carry(None)
    after_s = begin_s + SILENT_S + 3.0
    assert apart_m(traces, begin_s + SILENT_S) > 0.015
    assert apart_m(traces, after_s) <= apart_m(calm, after_s) + 1e-3
    grip_n, usual_n = (
        float(np.abs(each.users[0].f_applied[round(1000 * after_s) - 100 :][:300]).mean())
        for each in (traces, calm)
    )
    assert grip_n == pytest.approx(usual_n, rel=0.1)
    for energy in user_energies(traces, scenario):
        assert least_j(energy) >= LEAST_J
    user = traces.users[0]
    silent = (user.time_s > begin_s + 0.02) & (user.time_s < begin_s + SILENT_S)
    assert not user.f_applied[silent].any()  # no force on a dead sample


def resting(*settings):
    """Return how far from its avatar, beyond the undisturbed distance, a device whose hand rests
    is 3 s after the silence [m], and the energy that pressing it back would take [J].
    """
    scenario, traces = carry(3.0, "task.kind=hold", *settings, duration_s=6.5)
    _, calm = carry(None, "task.kind=hold", duration_s=6.5)  # where E0 does nothing
    user = traces.users[0]
    before_n, after_n = np.abs(user.f_applied[[2900, -1], 0])
    needed_j = (before_n**2 - after_n**2) / (2.0 * scenario.users[0].operator.stiffness)
    for energy in user_energies(traces, scenario):
        assert least_j(energy) >= LEAST_J
    return apart_m(traces, 6.3) - apart_m(calm, 6.3), needed_j, user_energies(traces, scenario)[0]


def test_a_hand_that_rests_is_pressed_back_as_far_as_e0_of_both_ways_pays():
    """Its arm has given up the force it did not feel times the way, here 17 mJ; with 10 mJ lent
    each way, 2 x 7.5 mJ can be spent."""
    left_m, _, _ = resting()
    assert 1e-4 < left_m <= 1.5e-3
    left_m, _, _ = resting("master.store_j=0.012", "server.store_j=0.012")
    assert left_m <= 1e-3


def test_a_hand_that_rests_cannot_be_pressed_back_by_what_is_passive():
    """Its arm, a spring k, needs (F0^2 - F1^2)/(2 k) to stand where it stood; nobody has that
    where no E0 is lent.
    """
    left_m, needed_j, energy = resting("master.store_j=0", "server.store_j=0")
    assert left_m > 0.01 and energy.joint.balance_j[-1] < needed_j


def test_a_device_unplugged_in_a_grip_is_silent_then_in_fault_and_its_avatar_holds():
    """Unplugged at 4 s: silent at 20 ms, a fault at 1 s; it comes back at 6 s, and has no force
    until it is re-armed at 7 s.
    """
    settings = ["task.kind=hold", "task.grip_s=0.3", "task.grip_rise_s=0.5"]
    scenario = files.load("carry_16ms", settings_texts=settings, duration_s=9.0)
    batch = SteppedSession(scenario)
    batch.advance(4 * 10**9)
    batch.users[0].device.sample.fresh = False
    batch.advance(6 * 10**9)
    batch.users[0].device.sample.fresh = True
    batch.advance(7 * 10**9)
    loop = batch.users[0].loop
    loop.hand_over(loop.rearm)
    batch.run(lambda _: None)
    traces = batch.traces()
    user, server = traces.users[0], traces.server
    time_s, force_n = user.time_s, np.abs(user.f_applied[:, 0])
    grip_n = force_n[time_s < 4.0][-1]
    assert grip_n > 1.0
    assert force_n[(time_s > 4.0) & (time_s < 4.0195)] == pytest.approx(grip_n)
    slew_s = grip_n / scenario.users[0].safety.max_slew
    away = (time_s > 4.0215 + slew_s) & (time_s < 7.0)
    assert not force_n[away].any()
    faults_s = user.block_time_s[np.array(user.state) == SafetyState.FAULT]
    assert 5.0 < faults_s.min() < 5.04 and 6.98 < faults_s.max() < 7.01
    rows = (server.time_s > 4.0) & (server.time_s < 6.0)
    assert np.ptp(server.x_s[0][rows]) < 1e-4 and np.ptp(server.f_s[0][rows]) < 0.05 * grip_n
    again = force_n[time_s > 7.0]
    assert again[:20].max() < 0.1 * grip_n and again[-1] > 0.3 * grip_n
    for energy in user_energies(traces, scenario):
        assert least_j(energy) >= LEAST_J
