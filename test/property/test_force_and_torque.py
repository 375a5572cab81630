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


@pytest.mark.parametrize(("max_torque", "share"), [(0.0, 1.0), (0.1, 0.25)])
def test_the_limit_of_a_torque_is_that_of_its_force_at_the_lever(max_torque, share):
    safety = SafetyParams(max_force=8.0, max_torque=max_torque)
    session = session_given(dof=6, server=ServerParams(lever_m=0.05))
    _, p = made_user(User("user1", side=-1, given_safety=safety), session, answer_tick=0)
    (force, one), (torque, found) = p.limits.groups
    assert (force, torque, one) == (BOTH[0][0], BOTH[1][0], 1.0)
    assert found == pytest.approx(share)
