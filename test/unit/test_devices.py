# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated device moves as mass, damper, friction and stops do."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, signal
from support.operators import TICK_S, Device

from pmwvc_core.errors import ParameterError
from pmwvc_core.law.motion import SERIES_BELOW, motion
from pmwvc_core.params import DeviceParams

masses = st.floats(0.01, 10.0)
dampings = st.one_of(st.just(0.0), st.floats(1e-9, 1e4))
forces = st.floats(-20.0, 20.0)
speeds = st.floats(-2.0, 2.0)


def device(*, tick_s=TICK_S, dof=1, x=0.0, xd=0.0, **params):
    params = DeviceParams(**{"workspace_m": 1e3} | params)
    return Device(params, x=x, xd=xd, dof=dof, tick_s=tick_s)


@given(masses, dampings, forces, forces, speeds)
def test_a_tick_is_the_zero_order_hold_of_mass_and_damper(mass, damping, f_h, f_m, xd):
    """The controller's force pushes against the hand's."""
    force = f_h - f_m
    a = np.array([[0.0, 1.0], [0.0, -damping / mass]])
    b = np.array([[0.0], [1.0 / mass]])
    phi, gamma, *_ = signal.cont2discrete((a, b, np.eye(2), np.zeros((2, 1))), TICK_S)
    made = device(mass=mass, damping=damping, x=0.1, xd=xd)
    made.step(f_h, f_m)
    expected = phi @ [0.1, xd] + gamma[:, 0] * force
    scale = 1.0 + (abs(f_h) + abs(f_m)) / mass
    np.testing.assert_allclose([made.x, made.xd], expected, rtol=1e-12, atol=1e-14 * scale)


def test_the_coefficients_have_no_seam_where_series_and_closed_form_meet():
    z = SERIES_BELOW * np.array([1.0 - 1e-9, 1.0, 1.0 + 1e-9])
    f_x = np.array([motion(1.0, each, 1.0).f_x for each in z])
    np.testing.assert_allclose(f_x, f_x[1], rtol=1e-9)
    np.testing.assert_allclose(f_x, (z + np.expm1(-z)) / z**2, rtol=1e-13)


@given(dampings.filter(lambda b: b < 1e3), st.floats(0.05, 1.0), st.floats(0.001, 1.0))
def test_friction_stops_the_device_where_the_closed_form_gives(damping, mass, friction):
    xd = 0.9 * TICK_S * friction / mass  # stops within the tick
    made = device(mass=mass, damping=damping, friction=friction, xd=xd)
    made.step(0.0, 0.0)
    assert made.xd == 0.0
    r = damping * xd / friction
    if r < 1e-3:
        stop = mass * xd**2 / (2.0 * friction) * (1.0 - 2.0 * r / 3.0)
    else:
        stop = mass * xd / damping * (1.0 - math.log1p(r) / r)
    assert made.x == pytest.approx(stop, rel=1e-5)


def test_a_force_below_friction_holds_nothing_and_moves_nothing():
    made = device(friction=0.5)
    for _ in range(10):
        made.step(0.5, 0.0)
    assert made.x == 0.0 and made.xd == 0.0
    made.step(0.6, 0.0)
    assert made.x > 0.0


def test_a_turn_within_a_tick_matches_a_fine_integration():
    mass, damping, friction, xd, force = 0.1, 3.0, 0.4, 0.004, -1.5

    def slope(_, state):
        return [state[1], (force - damping * state[1] - friction * np.sign(state[1])) / mass]

    def stop(_, state):
        return state[1]

    stop.terminal = True
    first = integrate.solve_ivp(slope, (0, TICK_S), [0.0, xd], events=stop, rtol=1e-12, atol=1e-15)
    rest_s = TICK_S - first.t[-1]
    assert rest_s > 0.0
    a = damping / mass
    end = (force + friction) / damping
    made = device(mass=mass, damping=damping, friction=friction, xd=xd)
    made.step(force, 0.0)
    assert made.xd == pytest.approx(end * (1 - math.exp(-a * rest_s)), rel=1e-8)
    moved = end * (rest_s - (1 - math.exp(-a * rest_s)) / a)
    assert made.x == pytest.approx(first.y[0, -1] + moved, rel=1e-7)


@given(forces, speeds, st.floats(-0.0999, 0.0999))
def test_a_stop_takes_all_of_the_motion_and_gives_none(force, xd, x):
    made = device(mass=0.1, workspace_m=0.1, x=x, xd=xd)
    for _ in range(200):
        before, start = 0.05 * made.xd**2, made.x
        made.step(force, 0.0)
        assert abs(made.x) <= 0.1
        work = force * (made.x - start)
        assert 0.05 * made.xd**2 <= before + work + 1e-12
        if abs(made.x) == 0.1:
            assert made.xd == 0.0


def test_a_device_cannot_start_outside_its_workspace():
    with pytest.raises(ParameterError, match=r"0\.3.*outside its workspace of \+-0\.2 m"):
        Device(DeviceParams(), x=0.3)


def test_the_encoder_shows_the_nearest_step():
    for x, shown in ((0.0149, 0.01), (0.0151, 0.02), (-0.0149, -0.01), (-0.0151, -0.02)):
        made = device(encoder_step_m=0.01, x=x)
        assert made.read() == (pytest.approx(shown), 0.0)
    assert made.x == -0.0151


def test_a_difference_of_readings_is_the_mean_velocity_of_the_tick():
    made = device(velocity="euler", mass=0.25)
    speeds = []
    for _ in range(5):
        made.step(1.0, 0.0)
        speeds.append(made.read()[1])
    true = 4.0 * TICK_S * (np.arange(5) + 0.5)
    np.testing.assert_allclose(speeds, true, rtol=1e-9)
    assert device(velocity="euler", x=0.5).read() == (0.5, 0.0)


def test_a_coarse_encoder_makes_a_difference_of_whole_steps():
    made = device(velocity="euler", encoder_step_m=1e-4, xd=0.03)
    steps = []
    for _ in range(200):
        made.step(0.0, 0.0)
        steps.append(made.read()[1] * TICK_S / 1e-4)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert set(np.round(steps)) == {0.0, 1.0}
    assert np.mean(steps) == pytest.approx(0.3, abs=0.01)


def turned(points, angle):
    cosine, sine = math.cos(angle), math.sin(angle)
    return points @ np.array([[cosine, sine], [-sine, cosine]])


def rubbed(angle, *, steps=400, friction=0.3):
    """Return the path of a device in a plane under forces that are turned by an angle."""
    made = Device(DeviceParams(mass=0.2, damping=0.5, friction=friction), dof=2)
    rng = np.random.default_rng(4)
    path = []
    for force in np.repeat(rng.normal(0.0, 0.5, (steps // 20, 2)), 20, axis=0):
        made.step(turned(force, angle), np.zeros(2))
        path.append(made.x)
    return np.array(path)


@pytest.mark.parametrize("angle", [0.3, 1.0, 2.5])
def test_friction_does_not_know_the_axes(angle):
    straight = rubbed(0.0)
    assert np.ptp(straight) > 1e-3
    np.testing.assert_allclose(rubbed(angle), turned(straight, angle), rtol=1e-9, atol=1e-12)


def test_friction_of_each_axis_for_itself_would_know_them():
    """The control: two devices of one axis each, turned."""

    def apart(angle):
        rng = np.random.default_rng(4)
        axes = [device(mass=0.2, damping=0.5, friction=0.3) for _ in range(2)]
        for force in np.repeat(rng.normal(0.0, 0.5, (20, 2)), 20, axis=0):
            for each, push in zip(axes, turned(force, angle), strict=True):
                each.step(float(push), 0.0)
        return np.array([each.x for each in axes])

    assert np.linalg.norm(apart(1.0) - turned(apart(0.0), 1.0)) > 1e-4


@given(forces, forces, speeds, st.floats(0.0, 5.0), st.integers(0, 2**32 - 1))
def test_friction_in_a_plane_only_takes_energy_and_no_more_than_it_can(
    one, two, xd, friction, seed
):
    mass = 0.3
    params = DeviceParams(mass=mass, damping=0.0, friction=friction, workspace_m=1e3)
    made = Device(params, xd=xd * np.random.default_rng(seed).normal(size=2), dof=2)
    for _ in range(20):
        push = np.array([one, two])
        before, start = 0.5 * mass * made.xd @ made.xd, made.x
        made.step(push, np.zeros(2))
        work = push @ (made.x - start)
        lost = before + work - 0.5 * mass * made.xd @ made.xd
        scale = 1e-12 * (1.0 + before + abs(work))
        assert lost >= -scale
