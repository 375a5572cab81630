# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Operators push as they say; a hand gives no energy but the work of its will."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal
from support.operators import HALF, TICK_S, device, forces, operator

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import TaskParams
from pmwvc_core.plant.hand import grip_force

device_masses = st.floats(0.05, 1.0)
grips = st.fixed_dictionaries(
    {
        "mass": st.floats(0.1, 3.0),
        "damping": st.floats(0.0, 20.0),
        "stiffness": st.floats(0.0, 200.0),
        "grip_stiffness": st.floats(0.0, 1000.0),
        "grip_damping": st.floats(0.0, 40.0),
    }
)


def test_no_operator_gives_zero_and_a_constant_one_its_force():
    assert not forces(operator("none"), 5).any()
    np.testing.assert_array_equal(forces(operator("constant", force=-1.5), 5), -1.5)


def test_a_sinusoid_starts_at_phase_zero():
    made = forces(operator("sinusoid", force=2.0, frequency_hz=5.0), 1000)
    wanted = 2.0 * np.sin(2 * np.pi * 5.0 * TICK_S * np.arange(1000))
    np.testing.assert_allclose(made, wanted, atol=1e-13)  # where it passes zero


def test_a_chirp_sweeps_as_scipys_does_and_goes_on_in_one_phase():
    made = forces(
        operator("chirp", force=1.0, frequency_hz=1.3, frequency_end_hz=40.0, sweep_s=1.0), 3000
    )
    first = signal.chirp(TICK_S * np.arange(1000), 1.3, 1.0, 40.0, phi=-90)
    np.testing.assert_allclose(made[:1000], first, atol=1e-9)
    largest_step = 2 * np.pi * 40.0 * TICK_S
    assert np.abs(np.diff(made)).max() <= largest_step  # also at the start of a new sweep


def test_time_stands_still_while_an_operator_holds():
    made = operator("sinusoid")
    assert [made.hold() for _ in range(5)] == [0.0] * 5
    np.testing.assert_array_equal(forces(made, 50), forces(operator("sinusoid"), 50))


def test_work_is_force_times_displacement():
    made, moving = operator("constant", force=2.0), device(0.25)
    for _ in range(101):
        moving.step(made.step(moving.x, moving.xd), 0.0)
    kinetic_before_last = 0.5 * 0.25 * (8.0 * 0.1) ** 2
    assert made.work_j == pytest.approx(kinetic_before_last, rel=1e-12)


def energies(hand, moving, params, device_mass):
    """Return kinetic and grip-spring energy, less that of the held damper (plant/hand.py)."""
    e, w = hand.y - moving.x, hand.yd - moving.xd
    beta = params["grip_damping"] + params["grip_stiffness"] * TICK_S / 2
    return (
        0.5 * device_mass * moving.xd**2
        + 0.5 * params["mass"] * hand.yd**2
        + 0.5 * params["stiffness"] * hand.y**2
        + 0.5 * params["grip_stiffness"] * e**2
        - 0.25 * beta * TICK_S * w**2
    )


@given(grips, device_masses, st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=60))
def test_grip_and_arm_change_their_energy_by_exactly_what_dampers_take(params, mass, pushes):
    """With the target at rest, what the device's own force brings is all that comes in."""
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
        work = -f_m * (moving.x - x)
        scale = 1e-12 * (1.0 + abs(before))
        assert change == pytest.approx(work - taken, rel=1e-8, abs=scale)


def radius(force, arm_mass, device_mass):
    """Return the spectral radius of a free device and a free arm joined by a held grip force."""
    columns = []
    for x, xd, y, yd in np.eye(4):
        f = force(y - x, yd - xd)
        columns.append(
            [
                x + TICK_S * xd + TICK_S**2 / 2 * f / device_mass,
                xd + TICK_S * f / device_mass,
                y + TICK_S * yd - TICK_S**2 / 2 * f / arm_mass,
                yd - TICK_S * f / arm_mass,
            ]
        )
    return np.abs(np.linalg.eigvals(np.array(columns).T)).max()


@pytest.mark.parametrize("mass", [0.05, 0.25, 1.0])
@pytest.mark.parametrize("grip_stiffness", [100.0, 375.0, 1000.0])
def test_a_grip_without_damper_keeps_its_energy_where_a_spring_held_naively_gains(
    mass, grip_stiffness
):
    grip = operator("hand", grip_stiffness=grip_stiffness, grip_damping=0.0).p.grip
    # Two eigenvalues at 1 (free motion, a double root) are known to about the root of rounding.
    held = radius(lambda lead, rate: grip_force((lead,), (rate,), grip)[0], 0.8, mass)
    assert held < 1.0 + 1e-7
    naive = radius(lambda lead, rate: grip_stiffness * lead, 0.8, mass)
    assert naive > 1.0 + 0.2 * grip_stiffness * TICK_S**2 / mass


@given(grips, device_masses)
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


@given(grips, device_masses, st.sampled_from([-1, 1]), st.integers(0, 2**32 - 1))
def test_a_hand_at_work_gives_no_more_than_its_effort(params, mass, side, seed):
    """Whatever pushes back: work on the device never exceeds will plus what was stored."""
    rng = np.random.default_rng(seed)
    params = params | {"grip_damping": params["grip_damping"] + 0.1}
    hand = operator("hand", task="carry", side=side, squeeze=2.0, **params)
    moving = device(mass, x=side * HALF)
    beta = params["grip_damping"] + params["grip_stiffness"] * TICK_S / 2
    for f_m in rng.normal(0.0, 3.0, 300).cumsum() * 0.1:
        moving.step(hand.step(moving.x, moving.xd), f_m)
        w = hand.yd - moving.xd
        held_j = 0.25 * beta * TICK_S * w**2  # the grip's, see plant/hand.py
        given_now = hand.work_j + hand.last_j(moving.x)
        assert given_now <= hand.effort_j + held_j + 1e-9 * (1.0 + abs(hand.effort_j))


@pytest.mark.parametrize("side", [-1, 1])
def test_a_closed_hand_holds_a_fixed_handle_with_the_squeezing_force(side):
    hand = operator("hand", task="hold", side=side, squeeze=1.25)
    squeezed = [hand.step(side * HALF, 0.0) for _ in range(8000)]
    assert not np.any(squeezed[:100])  # open until grip_s
    assert squeezed[-1] == pytest.approx(-side * 1.25, rel=1e-3)


def test_a_hand_closes_the_gap_it_starts_with():
    hand = operator("hand", task="hold", start=-HALF - 0.02, squeeze=0.0)
    moving = device(0.25, x=-HALF - 0.02)
    for _ in range(3000):
        moving.step(hand.step(moving.x, moving.xd), 2.0 * moving.xd)
    assert moving.x == pytest.approx(-HALF, abs=1e-4)


def test_a_hand_takes_hold_of_a_handle_that_was_moved_before_without_a_jerk():
    hand = operator("hand", task="hold", start=-HALF - 0.02)
    moved = device(0.25, x=-HALF - 0.01)  # 10 mm from its start, by a contact with no hand on it
    felt = []
    for _ in range(2000):
        felt.append(hand.step(moved.x, moved.xd))
        moved.step(felt[-1], 20.0 * moved.xd)
    assert felt[0] == 0.0
    assert np.abs(np.diff(felt)).max() < 0.1  # grip_stiffness times 10 mm are newtons


def test_two_hands_carry_the_target_each_on_its_side():
    hands = [operator("hand", task="carry", side=side, squeeze=0.0) for side in (-1, 1)]
    moving = [device(0.25, x=side * HALF) for side in (-1, 1)]
    for _ in range(1100):
        for hand, each in zip(hands, moving, strict=True):
            each.step(hand.step(each.x, each.xd), 0.0)
    np.testing.assert_allclose(
        [moving[0].x + HALF, moving[1].x - HALF], TaskParams().distance_m, atol=0.02
    )
    assert moving[1].x - moving[0].x == pytest.approx(2 * HALF, rel=1e-9)


def test_a_grip_too_stiff_for_the_tick_is_refused_with_the_limit():
    with pytest.raises(ParameterError, match=r"200 N s/m: must be < 94\.\d+ N s/m"):
        operator("hand", grip_damping=200.0, grip_stiffness=0.0)
    with pytest.raises(ParameterError, match="make the grip softer or the tick shorter"):
        operator("hand", tick_s=0.02)


def test_a_hand_in_three_axes_works_along_the_first():
    single = operator("hand", task="carry")
    hand = operator("hand", task="carry", dof=3)
    for _ in range(800):
        f = hand.step(np.array([-HALF, 0.0, 0.0]), np.zeros(3))
        np.testing.assert_allclose(f, [single.step(-HALF, 0.0), 0.0, 0.0], atol=1e-15)
    assert hand.effort_j == pytest.approx(single.effort_j)


def test_forces_on_floats_stay_floats():
    for kind in ("none", "constant", "sinusoid", "chirp", "hand"):
        made = operator(kind, task="carry")
        assert type(made.hold()) is float
        assert all(type(made.step(0.0, 0.0)) is float for _ in range(3))
        assert math.isfinite(made.work_j)
