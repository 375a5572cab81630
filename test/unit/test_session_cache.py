# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session cache of the tests gives what a simulation gives, and nobody can change it."""

import copy

import numpy as np
import pytest
from support import plain as scenarios
from support.simulated import judged, simulated

from pmwvc_core.simulation.session import simulate_one


def wall(duration_s=0.2):
    return scenarios.load("wall", duration_s=duration_s)


def test_cached_session_is_the_simulated_one_and_simulated_once():
    traces = simulated(wall())
    assert simulated(wall()) is traces
    np.testing.assert_array_equal(traces.users[0].x_m, simulate_one(wall()).users[0].x_m)
    assert simulated(wall(0.3)) is not traces


def test_cached_session_cannot_be_changed_but_its_copy_can():
    traces = simulated(wall())
    for signal in (traces.users[0].x_m, traces.server.f_s[0]):
        with pytest.raises(ValueError, match="read-only"):
            signal[0] = 1.0
    copy.deepcopy(traces).users[0].x_m[0] = 1.0
    judged(wall())["stable"] = "changed"
    assert judged(wall())["stable"] != "changed"
