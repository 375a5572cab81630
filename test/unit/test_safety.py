# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force limits, one by one and through the whole story of a session."""

import math

import numpy as np
import pytest
from support.law_rigs import ForceLimits

from pmwvc_core.law.safety.limits import RETURN_S
from pmwvc_core.master.safety import SafetyState

TICK_S = 0.001


def coupled(**params):
    """Return a rig behind its soft start, at zero force."""
    rig = ForceLimits(**params)
    rig(0.0, ticks=600)
    assert (rig.state, rig.reason) == (SafetyState.COUPLED, "")
    return rig


def test_the_force_rises_from_zero_over_the_soft_start():
    rig = ForceLimits(soft_start_s=0.5)
    forces = np.array([rig(2.0) for _ in range(500)])
    np.testing.assert_allclose(forces, 2.0 * np.arange(1, 501) / 500, rtol=1e-9)
    assert rig.reason == "soft start" or rig.state == SafetyState.COUPLED
    assert rig(2.0, ticks=2) == 2.0 and rig.ready
    assert (rig.state, rig.events) == (SafetyState.COUPLED, 0)


def test_above_the_damper_speed_a_force_may_only_brake():
    rig = coupled()
    rig(1.0)
    assert rig(1.0, 1.1) == 1.0  # opposes the motion: F = 1 N pushes against the hand
    assert rig(-1.0, 1.1) == 0.0  # would drive it on
    assert rig.state == SafetyState.DAMPING
    assert rig.reason == "faster than 1 m/s: damping only"
    vector = ForceLimits(axes=2)
    vector(np.zeros(2), ticks=600)
    sideways = vector(np.array([1.0, 1.0]), np.array([1.1, 0.0]))
    np.testing.assert_allclose(sideways, [1.0, 0.0])
    assert rig(0.5, 0.1) == pytest.approx(0.5 / 500)  # slower again: soft start
    assert rig.state == SafetyState.STARTING


def test_a_runaway_is_switched_off_until_rearmed():
    rig = coupled()
    rig(1.5)
    assert rig(1.5, 1.6) == 0.0
    assert rig.state == SafetyState.FAULT
    assert rig.reason == "faster than 1.5 m/s: no force until re-armed"
    assert rig(1.5, 0.0, ticks=5000) == 0.0
    assert rig.state == SafetyState.FAULT
    rig.rearm()
    assert rig(1.5) == pytest.approx(1.5 / 500)
    assert (rig(1.5, ticks=500), rig.state) == (1.5, SafetyState.COUPLED)


def test_moving_fast_without_a_rendered_force_is_no_fault():
    rig = ForceLimits()
    rig(0.0, 3.0, coupled=False)
    assert rig.state == SafetyState.STARTING


@pytest.mark.parametrize("broken", [math.nan, math.inf, -math.inf, 1e300])
@pytest.mark.parametrize("where", ["f", "x", "xd"])
def test_a_value_that_is_no_number_ends_the_force_and_a_soft_start_brings_it_back(broken, where):
    rig = coupled()
    rig(4.0, ticks=3)
    values = {"f": 4.0, "x": 0.0, "xd": 0.0} | {where: broken}
    forces = [rig(**values) for _ in range(3)]
    assert forces == [2.0, 0.0, 0.0]
    assert rig.state == SafetyState.DAMPING
    assert rig.reason == "a value is not a finite number: no force"
    assert rig(4.0) == pytest.approx(4.0 / 500)
    assert rig.state == SafetyState.STARTING


def test_silence_leaves_what_brakes_lets_go_what_pushes_and_later_all():
    rig = coupled(release_s=1.0)
    rig(1.0, 0.1)
    rig(1.0, 0.1, silence_s=0.030)
    assert rig.state == SafetyState.COUPLED  # 30 ms, or three packets: not yet
    assert rig(2.5, 0.1, silence_s=0.031) == 2.5
    assert (rig.state, rig.reason) == (SafetyState.DAMPING, "server silent: damping only")
    pushing = [rig(-1.0, 0.1, silence_s=0.05) for _ in range(25)]
    assert pushing[-1] == 0.0
    assert np.all(np.diff(pushing[3:]) >= 0.0)
    assert rig(2.5, 0.1, silence_s=0.9, ticks=3) == 2.5
    falling = [rig(2.5, 0.1, silence_s=1.1) for _ in range(600)]
    assert falling[249] == pytest.approx(1.25, rel=0.01)
    assert falling[-1] == 0.0
    assert (rig.state, rig.reason) == (SafetyState.DAMPING, "server silent: damping released")
    assert rig.events == 1


def test_silence_is_counted_in_packets_when_they_are_slow():
    rig = ForceLimits(timeout_s=0.03, packet_s=0.02)
    for silence_s, state in ((0.059, SafetyState.STARTING), (0.061, SafetyState.DAMPING)):
        rig(0.0, silence_s=silence_s)
        assert rig.state == state


def test_other_limits_are_taken_over_without_a_step():
    rig = coupled()
    rig(6.0, ticks=4)
    rig.configure(max_force=1.0, max_slew=500.0)
    forces = [6.0, *(rig(6.0) for _ in range(12))]
    np.testing.assert_allclose(np.abs(np.diff(forces)).max(), 0.5)
    assert forces[-1] == pytest.approx(1.0)
    assert rig.state == SafetyState.COUPLED


@pytest.mark.parametrize(("silent_ticks", "left"), [(1, 0.95), (10, 0.5), (20, 0.0), (200, 0.0)])
def test_after_a_silence_the_force_goes_on_from_what_had_not_faded(silent_ticks, left):
    rig = coupled()
    rig(2.0, ticks=20)
    rig(2.0, xd=-0.01, silence_s=0.05, ticks=silent_ticks)
    rise = TICK_S / RETURN_S
    assert rig(2.0) == pytest.approx(2.0 * (left + rise), abs=1e-9)
    assert rig(2.0, ticks=9) == pytest.approx(2.0 * min(left + 10 * rise, 1.0), abs=1e-9)


def test_a_force_from_before_another_server_fades_in_20_ms():
    rig = coupled()
    rig(2.0, ticks=20)
    rig.restart()
    forces = [2.0] + [rig(0.0) for _ in range(25)]
    assert forces[:21] == pytest.approx(np.linspace(2.0, 0.0, 21))
    assert forces[21:] == [0.0] * 5
    assert rig.events == 0


def test_too_fast_a_device_does_not_wait_for_that():
    rig = coupled()
    rig(2.0, ticks=20)
    rig.restart()
    assert rig(0.0, xd=-1.1) == 0.0
    assert rig(0.0) == 0.0
