# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The loss of a grip when packets come late together, as after a stall of a machine."""

import numpy as np
import pytest
from support import plain as scenarios

from pmwvc_core.frame import LIVE
from pmwvc_core.network.in_flight import RecordedFate, RecordedLink
from pmwvc_core.params import SafetyParams
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import simulate_one

FRAME_S, DELAY_S, LENGTH_S = 0.008, 0.016, 7.0
STALLS_S = (3.0, 4.5)


def stalled_link(pause_s):
    """Return a link that lets nothing out for a while, and then all of it at once."""
    record = {}
    for number in range(1, round(LENGTH_S / FRAME_S) + 2):
        sent_s = (number - 1) * FRAME_S
        out_s = sent_s + DELAY_S
        for stall_s in STALLS_S:
            if stall_s <= out_s < stall_s + pause_s:
                out_s = stall_s + pause_s
        record[number] = (RecordedFate(round((out_s - sent_s) * 1e9)),)
    return RecordedLink(record)


def carried(pause_s, *links):
    hold = ("task.kind=hold",)
    scenario = scenarios.load("carry_16ms", settings_texts=hold, duration_s=LENGTH_S)
    made = {link: (lambda: stalled_link(pause_s)) for link in links}
    return simulate_one(scenario, Conditions(schedule=LIVE, links=made))


def force_and_offset(traces):
    """Return user1's force [N] and device minus avatar [m], means over the last second."""
    user, x_s = traces.users[0], traces.server.x_s[0]
    return float(user.f_applied[-1000:].mean()), float(user.x_m[-1000:].mean() - x_s[-125:].mean())


def test_two_stalls_of_25_ms_cost_no_grip():
    undisturbed = force_and_offset(carried(0.0))
    force, offset = force_and_offset(carried(0.025, "user1/up", "user1/down"))
    assert force == pytest.approx(undisturbed[0], rel=0.02)
    assert offset == pytest.approx(undisturbed[1], abs=1e-4)


def test_a_longer_stall_lets_go_and_the_force_comes_back_without_a_step():
    traces = carried(0.1, "user1/down")
    force = traces.users[0].f_applied[:, 0]
    after = force[3100:]  # packets are back
    assert min(abs(after[:60])) < 0.1
    assert np.abs(np.diff(force)).max() <= SafetyParams().max_slew * 0.001 * (1 + 1e-9)
    assert after[1000] > 0.5
