# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The velocity behind the counts of an encoder."""

import math

import pytest

from pmwvc_core.law.port.counts import counts, resting_counts

STEP_M, TICK_S = 50e-6, 0.001


@pytest.mark.parametrize("towards", [1.0, -1.0])
def test_between_two_counts_the_velocity_only_falls_and_never_turns(towards):
    s, seen_m, velocities = resting_counts(0.0), 0.0, []
    for tick in range(600):
        true_m = towards * 0.02 * TICK_S * tick * (1.0 + 0.5 * math.sin(0.02 * tick))
        x_m = STEP_M * round(true_m / STEP_M)
        before, jump_m = s.xd, x_m - seen_m
        s, _ = counts(s, x_m, jump_m / TICK_S, TICK_S)
        if jump_m == 0.0 and s.rough:
            velocities.append(s.xd)
            assert min(0.0, before) <= s.xd <= max(0.0, before)
        seen_m = x_m
    assert len(velocities) > 100 and max(map(abs, velocities)) > 0.005
