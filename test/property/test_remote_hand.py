# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A remote hand gives no energy but the work of its target, whatever targets come and go."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.operators import TICK_S, Hand, device, driven

from pmwvc_core.params import OperatorParams
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
arms = st.builds(
    RemoteHandParams,
    mass=st.floats(0.1, 3.0),
    damping=st.floats(0.0, 40.0),
    stiffness=st.floats(10.0, 1000.0),
    speed_m_s=st.floats(0.05, 1.0),
    reach_n=st.floats(0.5, 20.0),
    brake=st.floats(0.0, 20.0),
)
hands = st.builds(
    OperatorParams,
    kind=st.just("remote"),
    grip_stiffness=st.floats(0.0, 1000.0),
    grip_damping=st.floats(0.0, 40.0),
    remote=arms,
)
places = st.one_of(
    st.floats(-0.2, 0.2),
    st.none(),
    st.sampled_from([math.nan, math.inf, -math.inf, 1e300, -1e300]),
)
streams = st.lists(st.tuples(st.integers(0, 250), places), max_size=30)


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
    grip = hand.remote.grip
    beta = params.grip_damping + params.grip_stiffness * TICK_S / 2
    square = grip * beta * (hand.yd - moving.xd) ** 2
    return 0.25 * TICK_S * (square + (1.0 - grip) * params.remote.brake * moving.xd**2)


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


def pushes_of(seed, ticks=TICKS):
    return np.random.default_rng(seed).normal(0.0, 3.0, ticks).cumsum() * 0.1


@settings(max_examples=40)
@given(hands, st.floats(0.05, 1.0), streams, st.integers(0, 2**32 - 1))
def test_no_tick_makes_energy_and_work_never_exceeds_the_effort(params, mass, gaps, seed):
    hand, moving = remote(params, arrivals(gaps)), device(mass)
    made, surplus = excess(hand, moving, params, mass, pushes_of(seed))
    assert made <= 1e-10
    assert surplus <= 1e-9


def holds(s, p):
    """Whether the hand will hold the handle in the tick that starts."""
    due = s.next < len(p.ticks) and p.ticks[s.next] <= s.tick
    wanted = p.rows[s.next, 0] if due else 0.0
    usable = math.isfinite(wanted) if due else s.hand.usable
    return usable and (s.hand.holding or s.hand.grip == s.hand.pull == 0.0)


def stiffening(s, x, p):
    """The control: the spring of the grip stiffens as it is."""
    hand, ratio = s.hand, s.hand.grip
    if not holds(s, p) or ratio == 0.0:
        return s
    share = 1.0 - math.sqrt(ratio / min(1.0, ratio + p.hand.rise))  # what the law will take away
    (y,), (target,) = hand.y, hand.target
    longer = (y - share * x[0]) / (1.0 - share)
    target = target - share * (x[0] - longer)
    return s._replace(hand=hand._replace(y=(longer,), target=(target,)))


def naive(s, x, p):
    """The control: the arm stays at the origin while nobody holds, and the grip closes at once."""
    if not holds(s, p) or s.hand.grip > 0.0:
        return s
    arm = s.hand._replace(y=(0.0,), target=(0.0,), holding=True, grip=1.0, pull=1.0)
    return s._replace(hand=arm)


def test_a_grip_that_closes_at_once_or_stiffens_as_it_is_makes_energy():
    """The controls: a handle that was pushed away is taken in motion."""
    targets = [*held(0, 100), (100, None), *held(400, TICKS)]
    pushes = [-3.0 if 200 <= tick < 420 else 0.0 for tick in range(TICKS)]
    made = {
        kind: excess(remote(targets=targets, before=kind), device(0.25), PARAMS, 0.25, pushes)
        for kind in (None, stiffening, naive)
    }
    assert made[None][0] <= 1e-12
    assert made[None][1] <= 0.0
    assert made[stiffening][0] > 1e-5
    assert made[naive][0] > 0.1
    assert made[naive][1] > 1e-2


@settings(max_examples=40)
@given(hands, st.floats(0.05, 1.0), st.floats(-0.1, 0.1), st.integers(100, 300))
def test_energy_only_falls_once_nobody_holds(params, mass, place, release):
    """Device, arm and springs together, nothing else pushing; then the handle is free."""
    hand, moving = remote(params, [*held(0, release, place), (release, None)]), device(mass)
    before = math.inf
    for tick in range(release + 200):
        f_h = hand.step(moving.x, moving.xd)
        moving.step(f_h, 0.0)
        if tick > release:  # the change of grip is part of the step: count its terms
            now = stored(hand, moving, params, mass) - (hand.effort_j if tick else 0.0)
            assert now <= before + 1e-9 * (1.0 + abs(now))
            before = now
    assert hand.remote.grip == hand.remote.pull == 0.0
    free = hand.step(moving.x, moving.xd)
    assert free == pytest.approx(-params.remote.brake * moving.xd)


def letting_go(targets, ticks, params=PARAMS, push=0.0):
    """Forces, speeds, and whether the handle was held, tick by tick."""
    hand, moving = remote(params, targets), device(0.25)
    rows = []
    for _ in range(ticks):
        f_h = hand.step(moving.x, moving.xd)
        rows.append((f_h, moving.xd, hand.holding))
        moving.step(f_h, push)
    return np.array(rows)


@pytest.mark.parametrize("end", [None, math.nan, math.inf])
def test_a_target_that_is_none_or_not_finite_lets_go_at_once(end):
    rows = letting_go([*held(0, 200, 0.02), (200, end)], 400)
    assert rows[199, 2]
    assert not rows[200:, 2].any()
    gone = 200 + round(FADE_S / TICK_S)
    np.testing.assert_allclose(rows[gone:, 0], -PARAMS.remote.brake * rows[gone:, 1], atol=1e-12)


def test_silence_lets_go_after_its_time_and_not_before():
    targets = held(0, 200)
    rows = letting_go(targets, 600)
    last = targets[-1][0]
    assert rows[last + round(SILENT_S / TICK_S), 2]
    assert not rows[last + round(SILENT_S / TICK_S) + 1 :, 2].any()
    assert letting_go(held(0, 600), 600)[:, 2].all()  # a target that rests holds


@settings(max_examples=30)
@given(streams, st.floats(-4.0, 4.0))
def test_force_has_no_step_however_targets_jump(gaps, push):
    """The change of force in a tick is bounded by rates and speeds, not by jumps of targets."""
    rows = letting_go(arrivals(gaps), TICKS, push=push)
    changes = np.abs(np.diff(rows[:, 0]))
    fastest = 0.5 + np.abs(rows[:, 1]).max() + PARAMS.remote.reach_n / PARAMS.remote.damping
    beta = PARAMS.grip_damping + PARAMS.grip_stiffness * TICK_S / 2
    most = np.abs(rows[:, 0]).max() + abs(push) + PARAMS.remote.reach_n
    limit = PARAMS.grip_stiffness * fastest * TICK_S  # springs stretch
    limit += beta * most * TICK_S * (1 / 0.25 + 1 / PARAMS.remote.mass)  # both masses accelerate
    limit += beta * fastest * TICK_S / TAKE_S + most * TICK_S / FADE_S  # the grip changes
    assert changes.max() <= limit


def taken_again(kind):
    """The largest change of force in a tick where the handle is taken far from the first place."""
    targets = [*held(0, 100), (100, None), *held(400, 900)]
    hand, moving = remote(targets=targets, before=kind), device(0.25)
    for tick in range(400):
        moving.step(hand.step(moving.x, moving.xd), -3.0 if tick > 200 else 0.0)
    assert abs(moving.x) > 0.05
    forces = [hand.f_h[0]]
    for _ in range(4):
        forces.append(hand.step(moving.x, moving.xd))
        moving.step(forces[-1], 0.0)
    assert hand.holding
    return np.abs(np.diff(forces)).max()


def test_taken_again_the_hand_begins_at_the_handle_however_far_it_is():
    assert taken_again(None) < 0.2
    assert taken_again(naive) > 10.0  # the control


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


def test_several_axes_are_a_vector_and_not_axis_by_axis():
    """The limits hold for its length."""
    hand = Hand((resting_remote((0.0,) * 3), remote_params(PARAMS, TICK_S)), axes=3)
    hand.s = remote_target(hand.s, (0.3, 0.4, 0.0))
    for _ in range(40):
        hand.step(np.zeros(3), np.zeros(3))
    course = hand.target / np.linalg.norm(hand.target)
    np.testing.assert_allclose(course, [0.6, 0.8, 0.0], atol=1e-9)
    assert np.linalg.norm(hand.target) <= PARAMS.remote.speed_m_s * 0.04 + 1e-12
