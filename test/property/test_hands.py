# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands push as they say, and give no energy but the work of their will or of their target."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal
from support.operators import HALF, TICK_S, Hand, device, driven, forces, operator

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.params.user import RemoteHandParams
from pmwvc_core.plant.remote_hand import (
    FADE_S,
    SILENT_S,
    TAKE_S,
    remote_params,
    remote_target,
    resting_remote,
)

TICKS = 700
PARAMS = OperatorParams(kind="remote")
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
remotes = st.builds(
    OperatorParams,
    kind=st.just("remote"),
    grip_stiffness=st.floats(0.0, 1000.0),
    grip_damping=st.floats(0.0, 40.0),
    remote=st.builds(
        RemoteHandParams,
        mass=st.floats(0.1, 3.0),
        damping=st.floats(0.0, 40.0),
        stiffness=st.floats(10.0, 1000.0),
        speed_m_s=st.floats(0.05, 1.0),
        reach_n=st.floats(0.5, 20.0),
        brake=st.floats(0.0, 20.0),
    ),
)
places = st.one_of(
    st.floats(-0.2, 0.2),
    st.none(),
    st.sampled_from([math.nan, math.inf, -math.inf, 1e300, -1e300]),
)
streams = st.lists(st.tuples(st.integers(0, 250), places), max_size=30)


def held_j(grip_stiffness, grip_damping, w):
    """Energy that a grip force held over a tick takes out, see plant/hand.py."""
    return 0.25 * TICK_S * (grip_damping + grip_stiffness * TICK_S / 2) * w**2


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


@settings(max_examples=10)  # each of 6 s
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


def pushes_of(seed, ticks=TICKS):
    return np.random.default_rng(seed).normal(0.0, 3.0, ticks).cumsum() * 0.1


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


# --- a remote hand ---------------------------------------------------------------------------


def arrivals(gaps):
    """Targets by the tick of their arrival, from the gaps between them."""
    ticks = np.cumsum([gap for gap, _ in gaps]).astype(int).tolist()
    return [(tick, place) for tick, (_, place) in zip(ticks, gaps, strict=True)]


def remote(params=PARAMS, targets=(), before=None):
    return Hand(driven(params, list(targets)), before=before)


def held(start, end, place=0.0):
    """Targets of somebody who holds still from one tick to another."""
    return [(tick, place) for tick in range(start, end, 14)]


def held_terms(hand, moving, params):
    """Energy of the forces held over a tick (see plant/remote_hand.py)."""
    w, grip = hand.yd - moving.xd, hand.remote.grip
    of_brake = 0.25 * TICK_S * params.remote.brake * moving.xd**2
    return grip * held_j(params.grip_stiffness, params.grip_damping, w) + (1.0 - grip) * of_brake


def stored(hand, moving, params, mass):
    """Energy of arm, springs and device, less that of the forces held."""
    return (
        0.5 * mass * moving.xd**2
        + 0.5 * params.remote.mass * hand.yd**2
        + 0.5 * hand.remote.grip * params.grip_stiffness * (hand.y - moving.x) ** 2
        + 0.5 * hand.remote.pull * params.remote.stiffness * (hand.target - hand.y) ** 2
        - held_terms(hand, moving, params)
    )


def excess(hand, moving, params, mass, pushes):
    """The largest energy that a tick made, and the largest surplus of work over effort [J]."""
    made, surplus = -math.inf, -math.inf
    for f_m in pushes:
        before, effort, x = stored(hand, moving, params, mass), hand.effort_j, moving.x
        moving.step(hand.step(moving.x, moving.xd), f_m)
        came = hand.effort_j - effort - f_m * (moving.x - x)
        now = stored(hand, moving, params, mass)
        made = max(made, (now - before - came) / (1.0 + abs(now) + abs(came)))
        work = hand.work_j + hand.last_j(moving.x)
        left = work - hand.effort_j - held_terms(hand, moving, params)
        surplus = max(surplus, left / (1.0 + abs(work)))
    return made, surplus


@settings(max_examples=40)
@given(remotes, masses, streams, seeds, st.integers(300, TICKS))
def test_no_tick_makes_energy_and_work_never_exceeds_the_effort(params, mass, gaps, seed, last):
    """Once nobody holds any more the handle is free, but for its brake."""
    targets = [each for each in arrivals(gaps) if each[0] < last] + [(last, None)]
    hand, moving = remote(params, targets), device(mass)
    made, surplus = excess(hand, moving, params, mass, pushes_of(seed, last + 200))
    assert made <= 1e-10
    assert surplus <= 1e-9
    assert hand.remote.grip == hand.remote.pull == 0.0
    free = hand.step(moving.x, moving.xd)
    assert free == pytest.approx(-params.remote.brake * moving.xd)


@pytest.mark.parametrize("brake", [0.0, 5.0])
def test_without_dampers_every_joule_is_the_effort_s_while_the_hand_closes(brake):
    """On a handle in motion; the handle's own brake takes what the grip leaves it."""
    arm = RemoteHandParams(damping=0.0, brake=brake)
    params = OperatorParams(kind="remote", grip_stiffness=500.0, grip_damping=0.0, remote=arm)
    hand, moving = remote(params, held(0, 300, 0.01)), device(0.25)
    moving.s = moving.s._replace(xd=(0.3,))
    for f_m in pushes_of(3, 300):
        before, effort = stored(hand, moving, params, 0.25), hand.effort_j
        x, xd = moving.x, moving.xd
        moving.step(hand.step(moving.x, moving.xd), f_m)
        heat = (1.0 - hand.remote.grip) * brake * (0.5 * (xd + moving.xd)) ** 2 * TICK_S
        came = hand.effort_j - effort - f_m * (moving.x - x) - heat
        assert stored(hand, moving, params, 0.25) - before == pytest.approx(came, abs=1e-12)


def holds(s, p):
    """Whether the hand will hold the handle in the tick that starts."""
    due = s.next < len(p.ticks) and p.ticks[s.next] <= s.tick
    wanted = p.rows[s.next, 0] if due else 0.0
    usable = math.isfinite(wanted) if due else s.hand.usable
    return usable and (s.hand.holding or s.hand.grip == s.hand.pull == 0.0)


def naive(s, x, p):
    """The control: the arm stays at the origin while nobody holds, and the grip closes at once."""
    if not holds(s, p) or s.hand.grip > 0.0:
        return s
    arm = s.hand._replace(y=(0.0,), target=(0.0,), holding=True, grip=1.0, pull=1.0)
    return s._replace(hand=arm)


AWAY = [*held(0, 100), (100, None), *held(400, 900)]  # in between the handle is pushed away


def test_control_a_grip_that_closes_at_once_makes_energy():
    """A handle that was pushed away is taken in motion."""
    pushes = [-3.0 if 200 <= tick < 420 else 0.0 for tick in range(TICKS)]
    made, forces = {}, {}
    for kind in (None, naive):
        hand, moving = remote(targets=AWAY, before=kind), device(0.25)
        made[kind] = excess(hand, moving, PARAMS, 0.25, pushes)
        hand, moving = remote(targets=AWAY, before=kind), device(0.25)
        forces[kind] = []
        for tick in range(404):
            forces[kind].append(hand.step(moving.x, moving.xd))
            moving.step(forces[kind][-1], -3.0 if 200 < tick < 400 else 0.0)
        assert abs(moving.x) > 0.05 and hand.holding
    assert made[None][0] <= 1e-12
    assert made[None][1] <= 0.0
    assert made[naive][0] > 0.1
    assert made[naive][1] > 1e-2
    assert np.abs(np.diff(forces[None][-5:])).max() < 0.2  # taken again, it begins at the handle
    assert np.abs(np.diff(forces[naive][-5:])).max() > 10.0


def letting_go(targets, ticks, push=0.0):
    """Forces, speeds, and whether the handle was held, tick by tick."""
    hand, moving = remote(PARAMS, targets), device(0.25)
    rows = []
    for _ in range(ticks):
        f_h = hand.step(moving.x, moving.xd)
        rows.append((f_h, moving.xd, hand.holding))
        moving.step(f_h, push)
    return np.array(rows)


@pytest.mark.parametrize("end", [None, math.nan, math.inf, "silence"])
def test_a_target_that_is_none_or_not_finite_and_silence_let_go(end):
    targets, gone = held(0, 200, 0.02), 200
    if end == "silence":
        gone = targets[-1][0] + round(SILENT_S / TICK_S) + 1
    else:
        targets.append((gone, end))
    rows = letting_go(targets, 600)
    assert rows[gone - 1, 2]
    assert not rows[gone:, 2].any()
    rows = rows[gone + round(FADE_S / TICK_S) :]
    np.testing.assert_allclose(rows[:, 0], -PARAMS.remote.brake * rows[:, 1], atol=1e-12)
    assert letting_go(held(0, 600), 600)[:, 2].all()  # a target that rests holds


@settings(max_examples=30)
@given(streams, st.floats(-4.0, 4.0))
def test_force_has_no_step_however_targets_jump(gaps, push):
    """The change of force in a tick is bounded by rates and speeds, not by jumps of targets."""
    rows = letting_go(arrivals(gaps), TICKS, push)
    changes = np.abs(np.diff(rows[:, 0]))
    fastest = 0.5 + np.abs(rows[:, 1]).max() + PARAMS.remote.reach_n / PARAMS.remote.damping
    beta = PARAMS.grip_damping + PARAMS.grip_stiffness * TICK_S / 2
    most = np.abs(rows[:, 0]).max() + abs(push) + PARAMS.remote.reach_n
    limit = PARAMS.grip_stiffness * fastest * TICK_S  # springs stretch
    limit += beta * most * TICK_S * (1 / 0.25 + 1 / PARAMS.remote.mass)  # both masses accelerate
    limit += beta * fastest * TICK_S / TAKE_S + most * TICK_S / FADE_S  # the grip changes
    assert changes.max() <= limit


def test_target_is_slewed_and_never_out_of_reach():
    hand = remote(targets=held(0, 900, 0.5))
    seen = []
    for _ in range(900):
        hand.step(0.0, 0.0)  # the handle is fixed
        seen.append((hand.target, hand.y))
    target, y = np.array(seen).T
    assert np.diff(target).max() <= PARAMS.remote.speed_m_s * TICK_S + 1e-12
    assert (target - y).max() == pytest.approx(PARAMS.remote.reach_n / PARAMS.remote.stiffness)
    assert hand.f_h[0] < PARAMS.remote.reach_n + 1e-9
    # Several axes are a vector and not axis by axis: the limits hold for its length.
    hand = Hand((resting_remote((0.0,) * 3), remote_params(PARAMS, TICK_S)), axes=3)
    hand.s = remote_target(hand.s, (0.3, 0.4, 0.0))
    for _ in range(40):
        hand.step(np.zeros(3), np.zeros(3))
    course = hand.target / np.linalg.norm(hand.target)
    np.testing.assert_allclose(course, [0.6, 0.8, 0.0], atol=1e-9)
    assert np.linalg.norm(hand.target) <= PARAMS.remote.speed_m_s * 0.04 + 1e-12
