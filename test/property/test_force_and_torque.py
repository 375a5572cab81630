# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Force and torque are limited apart: neither takes from the other."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import ForceLimits
from support.session_given import session_given

from pmwvc_core.made.user import made_user
from pmwvc_core.params import SafetyParams, ServerParams
from pmwvc_core.scenario.scenario import User

SHARE, SOON = 0.25, {"soft_start_s": 0.01}
BOTH = ((1.0,) * 3 + (0.0,) * 3, 1.0), ((0.0,) * 3 + (1.0,) * 3, SHARE)
forces = st.lists(st.tuples(*[st.floats(-30.0, 30.0)] * 6), min_size=1, max_size=30)


@settings(max_examples=30, deadline=None)
@given(asked=forces)
def test_each_is_what_it_would_be_alone(asked):
    both, force = ForceLimits(axes=6, groups=BOTH, **SOON), ForceLimits(axes=3, **SOON)
    torque = ForceLimits(axes=3, max_force=8.0 * SHARE, max_slew=2000.0 * SHARE, **SOON)
    for each in (both, force, torque):
        each(np.zeros(each.axes), ticks=12)
    for f in np.array(asked):
        found = both(f)
        np.testing.assert_allclose(found[:3], force(f[:3]), atol=1e-12)
        np.testing.assert_allclose(found[3:], torque(f[3:]), atol=1e-12)


def test_limited_together_a_torque_would_take_force_away():
    apart, together = ForceLimits(axes=6, groups=BOTH, **SOON), ForceLimits(axes=6, **SOON)
    for each in (apart, together):
        each(np.zeros(6), ticks=12)
        each(np.array([8.0, 0.0, 0.0, 0.0, 0.0, 40.0]), ticks=30)
    np.testing.assert_allclose(apart.s.f, [8.0, 0.0, 0.0, 0.0, 0.0, 2.0])
    assert together.s.f[0] < 2.0


FAST, STILL = 1.2, 0.0  # m/s; only damped from 1 on


@pytest.mark.parametrize(("turns", "moves"), [(FAST, STILL), (STILL, FAST)])
def test_a_handle_that_turns_too_fast_keeps_its_force_and_one_that_moves_too_fast_its_torque(
    turns, moves
):
    """What is too fast alone is only damped, at once; afterwards that alone starts softly."""
    limits, f = ForceLimits(axes=6, groups=BOTH, **SOON), np.array([4.0, 0, 0, 0, 0, 1.0])
    limits(f, ticks=30)
    applied = limits(f, xd=-np.array([moves, 0, 0, 0, 0, turns]), ticks=30)
    np.testing.assert_array_equal(applied != 0.0, [not moves, 0, 0, 0, 0, not turns])
    assert limits.reason.startswith("faster than")
    first = limits(f)
    assert (first[0] == 4.0, first[5] == 1.0) == (not moves, not turns)
    np.testing.assert_allclose(limits(f, ticks=30), f)


def test_speeds_are_limited_apart_not_by_their_norm():
    """Six axes as one group are too fast (the control)."""
    f, xd = np.array([1.0, 0, 0, 0, 0, 0.5]), -np.array([0.8, 0, 0, 0, 0, 0.8])
    found = []
    for groups in (BOTH, None):
        limits = ForceLimits(axes=6, groups=groups, **SOON)
        limits(f, ticks=30)
        found.append(limits(f, xd=xd, ticks=30))
    np.testing.assert_array_equal(found[0], f)
    assert not found[1].any()


def test_the_brake_holds_force_and_torque_each_by_what_was_felt_of_it():
    """As many as one group a torque is held with the force's strength, too (the control)."""
    found = []
    for groups in (BOTH, None):
        limits = ForceLimits(axes=6, groups=groups, brake=100.0, **SOON)
        limits(np.array([4.0, 0, 0, 0, 0, 0.2]), ticks=600)
        way = np.zeros(6)
        for _ in range(200):
            way[5] += 0.001
            applied = limits(np.zeros(6), x=way.copy(), interrupted=True)
        found.append(applied[5])
    assert found[0] == pytest.approx(1.3 * 0.2, rel=0.01)
    assert found[1] == pytest.approx(1.3 * np.hypot(4.0, 0.2), rel=0.1)


@pytest.mark.parametrize(("max_torque", "share"), [(0.0, 1.0), (0.1, 0.25)])
def test_the_limit_of_a_torque_is_that_of_its_force_at_the_lever(max_torque, share):
    safety = SafetyParams(max_force=8.0, max_torque=max_torque)
    session = session_given(dof=6, server=ServerParams(lever_m=0.05))
    _, p = made_user(User("user1", side=-1, given_safety=safety), session, answer_tick=0)
    (force, one), (torque, found) = p.limits.groups
    assert (force, torque, one) == (BOTH[0][0], BOTH[1][0], 1.0)
    assert found == pytest.approx(share)
