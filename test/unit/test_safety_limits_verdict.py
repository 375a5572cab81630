# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict on stability where safety limits took over."""

import numpy as np
import pytest
from support import handmade
from support.handmade import oscillating, session

from pmwvc_analysis.verdicts.stability import verdict


def judged(traces):
    """The kind of instability, None for stable."""
    return verdict(traces, handmade.scenario()).instability


def test_a_fault_is_named_as_safety():
    traces = session()
    traces.users[0].state[400:] = 3
    traces.users[0].reason[400:] = ["speed"] * 100
    assert judged(traces) == "limited by safety"


@pytest.mark.parametrize(
    ("times", "reason", "instability"),
    [
        (3, "faster than 1 m/s: damping only", "limited by safety"),
        (2, "faster than 1 m/s: damping only", None),
        (9, "server silent: damping only", None),
    ],
)
def test_being_braked_again_and_again_is_named_as_safety(times, reason, instability):
    traces = session()
    user = traces.users[0]
    for place in range(times):
        user.state[300 + 10 * place] = 2
        user.reason[300 + 10 * place] = reason
    assert judged(traces) == instability


@pytest.mark.parametrize(("blocks", "instability"), [(12, None), (13, "limited by safety")])
def test_being_braked_for_long_is_named_as_safety(blocks, instability):
    """Of 250 blocks in the second half: a twentieth, and a block more."""
    traces = session()
    user = traces.users[0]
    user.state[300 : 300 + blocks] = 2
    user.reason[300 : 300 + blocks] = ["faster than 1 m/s: damping only"] * blocks
    assert judged(traces) == instability


def test_force_shortened_again_and_again_is_named_as_safety():
    traces = session()
    user = traces.users[0]
    shortened = np.sin(2 * np.pi * 5.0 * user.time_s) > 0.5
    user.f_applied = np.where(shortened[:, np.newaxis], 0.5 * user.f_m, user.f_m)
    assert judged(traces) == "limited by safety"


@pytest.mark.parametrize(
    ("shaken_m_s", "instability", "stable"),
    [(5e-3, "limited by safety", False), (0.0, None, None)],
)
def test_force_at_its_limit_is_the_loop_s_where_something_oscillates(
    shaken_m_s, instability, stable
):
    """Else it may be that of a hand that presses harder than the device can."""
    traces = oscillating(session(), rms_m_s=shaken_m_s, hertz=5.0)
    user = traces.users[0]
    user.f_m = user.f_m * (1.0 + 0.5 * np.sin(2 * np.pi * 2.0 * user.time_s)[:, np.newaxis])
    user.f_applied = np.minimum(user.f_m, 1.2)
    found = verdict(traces, handmade.scenario())
    assert (found.instability, found.stable) == (instability, stable)
    assert "user1: the force was limited" in found.why


def test_force_shortened_once_is_no_instability():
    traces = session()
    user = traces.users[0]
    once = (user.time_s > 2.5) & (user.time_s < 2.8)
    user.f_applied = np.where(once[:, np.newaxis], 0.5 * user.f_m, user.f_m)
    assert judged(traces) is None


def test_a_force_that_returns_after_a_stall_was_not_braked_for_speed():
    traces = session()
    user = traces.users[0]
    for place in range(5):
        block = 300 + 20 * place
        user.state[block] = 0
        user.reason[block] = "soft start"
    assert judged(traces) is None
