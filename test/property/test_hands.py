# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands push as they say, and give no energy but the work of their will."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal
from support.operators import HALF, TICK_S, device, forces, held_j, operator, pushes_of

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import TaskParams

masses = st.floats(0.05, 1.0)
seeds = st.integers(0, 2**32 - 1)
grips = st.fixed_dictionaries(
    {
        "mass": st.floats(0.1, 3.0),
        "damping": st.floats(0.0, 20.0),
        "stiffness": st.floats(0.0, 200.0),
        "grip_stiffness": st.floats(0.0, 1000.0),
        "grip_damping": st.floats(0.0, 40.0),
    }
)


def test_operators_without_a_hand_push_as_they_say():
    assert not forces(operator("none"), 5).any()
    np.testing.assert_array_equal(forces(operator("constant", force=-1.5), 5), -1.5)
    time_s = TICK_S * np.arange(1000)
    made = forces(operator("sinusoid", force=2.0, frequency_hz=5.0), 1000)
    np.testing.assert_allclose(made, 2.0 * np.sin(2 * np.pi * 5.0 * time_s), atol=1e-13)
    sweep = {"frequency_hz": 1.3, "frequency_end_hz": 40.0, "sweep_s": 1.0}
    made = forces(operator("chirp", force=1.0, **sweep), 3000)
    first = signal.chirp(time_s, 1.3, 1.0, 40.0, phi=-90)
    np.testing.assert_allclose(made[:1000], first, atol=1e-9)
    assert np.abs(np.diff(made)).max() <= 2 * np.pi * 40.0 * TICK_S  # also at a new sweep
    held = operator("sinusoid")
    assert [held.hold() for _ in range(5)] == [0.0] * 5  # its time stands still
    np.testing.assert_array_equal(forces(held, 50), forces(operator("sinusoid"), 50))


def energies(hand, moving, params, mass):
    """Return kinetic and spring energy of a hand, less that of the held damper."""
    return (
        0.5 * mass * moving.xd**2
        + 0.5 * params["mass"] * hand.yd**2
        + 0.5 * params["stiffness"] * hand.y**2
        + 0.5 * params["grip_stiffness"] * (hand.y - moving.x) ** 2
        - held_j(params["grip_stiffness"], params["grip_damping"], hand.yd - moving.xd)
    )


@given(
    grips, masses, st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=60), st.floats(0.01, 0.1)
)
def test_grip_and_arm_change_their_energy_by_exactly_what_dampers_take(
    params, mass, pushes, stretch
):
    """With the target at rest, what the device's own force brings is all that comes in. A spring
    without the damper that its held force needs gains (the control).
    """
    hand, moving = operator("hand", start=0.0, side=-1, **params), device(mass)
    hand.p = hand.p._replace(face=(0.0,), gap=(0.0,))
    hand.s = hand.s._replace(target=(0.0,))
    for f_m in pushes:
        before = energies(hand, moving, params, mass)
        x, y, w = moving.x, hand.y, hand.yd - moving.xd
        moving.step(hand.step(moving.x, moving.xd), f_m)
        w_mean = 0.5 * (w + hand.yd - moving.xd)
        taken = params["grip_damping"] * TICK_S * w_mean**2
        taken += params["damping"] * (hand.y - y) ** 2 / TICK_S
        change = energies(hand, moving, params, mass) - before
        scale = 1e-12 * (1.0 + abs(before))
        assert change == pytest.approx(-f_m * (moving.x - x) - taken, rel=1e-8, abs=scale)
    k, x, xd = 500.0, stretch, 0.0  # a device at a spring held fixed
    for _ in range(200):
        xd, x = xd - TICK_S * k * x / mass, x + TICK_S * xd - TICK_S**2 / 2 * k * x / mass
    assert mass * xd**2 + k * x**2 > k * stretch**2


@settings(max_examples=6)  # each of 6 s
@given(grips, masses)
def test_a_hand_left_alone_comes_to_rest_and_does_no_lasting_work(params, mass):
    params = params | {"stiffness": 50.0 + params["stiffness"], "damping": 5.0 + params["damping"]}
    params |= {"grip_stiffness": 100.0 + params["grip_stiffness"], "grip_damping": 5.0}
    hand, moving = operator("hand", **params), device(mass, x=-HALF)
    moving.s = moving.s._replace(xd=(0.3,))
    start = 0.5 * mass * 0.3**2
    for _ in range(6000):
        moving.step(hand.step(moving.x, moving.xd), 0.0)
        assert hand.work_j <= 1e-12
        assert 0.5 * mass * moving.xd**2 <= start * (1.0 + 1e-9)
    assert moving.x == pytest.approx(-HALF, abs=1e-3)
    assert abs(moving.xd) < 0.02


@given(grips, masses, st.sampled_from([-1, 1]), seeds)
def test_a_hand_at_work_gives_no_more_than_its_effort(params, mass, side, seed):
    """Whatever pushes back: work on the device never exceeds will plus what was stored."""
    params = params | {"grip_damping": params["grip_damping"] + 0.1}
    hand = operator("hand", task="carry", side=side, squeeze=2.0, **params)
    moving = device(mass, x=side * HALF)
    for f_m in pushes_of(seed, 300):
        moving.step(hand.step(moving.x, moving.xd), f_m)
        held = held_j(params["grip_stiffness"], params["grip_damping"], hand.yd - moving.xd)
        given_now = hand.work_j + hand.last_j(moving.x)
        assert given_now <= hand.effort_j + held + 1e-9 * (1.0 + abs(hand.effort_j))


@pytest.mark.parametrize("side", [-1, 1])
def test_a_closed_hand_holds_a_fixed_handle_with_the_squeezing_force(side):
    hand = operator("hand", task="hold", side=side, squeeze=1.25)
    squeezed = [hand.step(side * HALF, 0.0) for _ in range(8000)]
    assert not np.any(squeezed[:100])  # open until grip_s
    assert squeezed[-1] == pytest.approx(-side * 1.25, rel=1e-3)


@pytest.mark.parametrize("moved_m", [0.0, 0.01])
def test_a_hand_closes_the_gap_it_starts_with_and_takes_hold_without_a_jerk(moved_m):
    """Also of a handle that was moved before, by a contact with no hand on it."""
    hand = operator("hand", task="hold", start=-HALF - 0.02, squeeze=0.0)
    moving, felt = device(0.25, x=-HALF - 0.02 + moved_m), []
    for _ in range(3000):
        felt.append(hand.step(moving.x, moving.xd))
        moving.step(felt[-1], 2.0 * moving.xd)
    assert moving.x == pytest.approx(-HALF, abs=1e-4)
    assert felt[0] == 0.0
    assert np.abs(np.diff(felt)).max() < 0.1  # grip_stiffness times 10 mm are newtons


def test_two_hands_carry_the_target_each_on_its_side_along_the_first_axis():
    hands = [operator("hand", task="carry", side=side, squeeze=0.0) for side in (-1, 1)]
    moving = [device(0.25, x=side * HALF) for side in (-1, 1)]
    third = operator("hand", task="carry", side=-1, squeeze=0.0, dof=3)
    for _ in range(1100):
        at = np.array([moving[0].x, 0.0, 0.0]), np.array([moving[0].xd, 0.0, 0.0])
        pushes = [hand.step(each.x, each.xd) for hand, each in zip(hands, moving, strict=True)]
        np.testing.assert_allclose(third.step(*at), [pushes[0], 0.0, 0.0], atol=1e-15)
        for push, each in zip(pushes, moving, strict=True):
            each.step(push, 0.0)
    ends = [moving[0].x + HALF, moving[1].x - HALF]
    np.testing.assert_allclose(ends, TaskParams().distance_m, atol=0.02)
    assert moving[1].x - moving[0].x == pytest.approx(2 * HALF, rel=1e-9)
    assert third.effort_j == pytest.approx(hands[0].effort_j)


def test_a_grip_too_stiff_for_the_tick_is_refused_with_the_limit():
    with pytest.raises(ParameterError, match=r"200 N s/m: must be < 94\.\d+ N s/m"):
        operator("hand", grip_damping=200.0, grip_stiffness=0.0)
    with pytest.raises(ParameterError, match="make the grip softer or the tick shorter"):
        operator("hand", tick_s=0.02)
