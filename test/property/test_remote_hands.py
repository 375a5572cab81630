# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A hand that follows a target from outside gives no energy but the work of that target, and no
step of force however the target jumps.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.operators import (
    TICK_S,
    Hand,
    device,
    driven,
    held_j,
    pushes_of,
)

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
masses = st.floats(0.05, 1.0)
seeds = st.integers(0, 2**32 - 1)
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


@settings(max_examples=12)
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


@settings(max_examples=15)
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
