# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Force and torque are limited, and in an outage held, apart: neither takes from the other."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import ForceLimits, Users, loose_avatar
from support.session_given import session_given
from support.strategies import text_of

from pmwvc_core.law.safety.brakes import braked
from pmwvc_core.law.server.server_port import Came, environment_step
from pmwvc_core.law.wave.wave import impedance
from pmwvc_core.made.server import brakes_of
from pmwvc_core.made.user import groups_of, made_user
from pmwvc_core.params import ContactParams, SafetyParams, ServerParams
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import User

B, PERIOD_S = 25.0, 0.008
SHARE, SOON = 0.25, {"soft_start_s": 0.01}
BOTH = ((1.0,) * 3 + (0.0,) * 3, 1.0), ((0.0,) * 3 + (1.0,) * 3, SHARE)
forces = st.lists(st.tuples(*[st.floats(-30.0, 30.0)] * 6), min_size=1, max_size=30)


@settings(max_examples=20, deadline=None)
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


FAST, STILL = 1.2, 0.0  # m/s; only damped from 1 on


@pytest.mark.parametrize(("turns", "moves"), [(FAST, STILL), (STILL, FAST)])
def test_a_handle_that_turns_too_fast_keeps_its_force_and_one_that_moves_too_fast_its_torque(
    turns, moves
):
    """What is too fast alone is only damped, at once; afterwards that alone starts softly."""
    limits, f = ForceLimits(axes=6, groups=BOTH, **SOON), np.array([4.0, 0, 0, 0, 0, 1.0])
    limits(f, ticks=30)
    applied = limits(f, xd=-np.array([moves, 0, 0, 0, 0, turns]), ticks=30)
    np.testing.assert_array_equal(applied != 0.0, [not moves, 0, 0, 0, 0, not turns])
    assert limits.reason.startswith("faster than")
    first = limits(f)
    assert (first[0] == 4.0, first[5] == 1.0) == (not moves, not turns)
    np.testing.assert_allclose(limits(f, ticks=30), f)


def test_speeds_are_limited_apart_not_by_their_norm():
    """Six axes as one group are too fast (the control)."""
    f, xd = np.array([1.0, 0, 0, 0, 0, 0.5]), -np.array([0.8, 0, 0, 0, 0, 0.8])
    found = []
    for groups in (BOTH, None):
        limits = ForceLimits(axes=6, groups=groups, **SOON)
        limits(f, ticks=30)
        found.append(limits(f, xd=xd, ticks=30))
    np.testing.assert_array_equal(found[0], f)
    assert not found[1].any()


def test_the_brake_holds_force_and_torque_each_by_what_was_felt_of_it():
    """As many as one group a torque is held with the force's strength, too (the control)."""
    found = []
    for groups in (BOTH, None):
        limits = ForceLimits(axes=6, groups=groups, brake=100.0, **SOON)
        limits(np.array([4.0, 0, 0, 0, 0, 0.2]), ticks=600)
        way = np.zeros(6)
        for _ in range(200):
            way[5] += 0.001
            applied = limits(np.zeros(6), x=way.copy(), interrupted=True)
        found.append(applied[5])
    assert found[0] == pytest.approx(1.3 * 0.2, rel=0.01)
    assert found[1] == pytest.approx(1.3 * np.hypot(4.0, 0.2), rel=0.1)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), size=st.sampled_from((0.1, 1.0, 5.0)))
def test_the_brakes_of_an_avatar_are_each_what_it_would_be_alone(seed, size):
    rng, b, groups = np.random.default_rng(seed), impedance(B), groups_of(6)
    both, alone = loose_avatar(6), [loose_avatar(3)] * 2
    for step in range(80):
        u, f = (tuple((size * rng.normal(size=6)).tolist()) for _ in range(2))
        how = step % 20 > 10, PERIOD_S
        both, *_ = braked(both, b, u, f, *how, groups)
        for i in range(2):
            part = slice(3 * i, 3 * i + 3)
            alone[i], *_ = braked(alone[i], b, u[part], f[part], *how, groups_of(3))
            assert both.n[part] == alone[i].n


def twisted(turns_n, *, brakes=None):
    """Two hands hold a cube with 2 N, the waves of one fail, and the other one turns it with a
    torque of so much at the lever: return force and torque of the one after a second [N].
    """
    server = ServerParams(object_mass=0.2)
    users = Users(server, [ContactParams()] * 2, b=B, axes=6, channel="strict")
    if brakes:
        users.p = users.p._replace(brakes=brakes)
        ports = (port._replace(brake=loose_avatar(6, brakes)) for port in users.s.ports)
        users.s = users.s._replace(ports=tuple(ports))
    for user, at in enumerate((-0.05, 0.05)):
        users.join(user, np.array([at, 0.0, 0.0, 0.0, 0.0, 0.0]))
    for step in range(375):
        late, came = step - 250, []
        for user, pull in enumerate((2.0, -2.0)):
            fades = math.exp(-max(late - 3, 0) * PERIOD_S / 0.03) if user == 0 else 1.0
            drive = [pull * fades, 0.0, 0.0, 0.0, 0.0, turns_n if user and late > 4 else 0.0]
            u = tuple((np.array(drive) / math.sqrt(2.0 * B)).tolist())
            came.append(Came(u, (0.0,) * 6, user == 0 and late > 4, 0.0, ()))
        users.s = environment_step(users.p, users.s, tuple(came))
        heat_j = users.dissipated + users.energies["avatar_brakes"]
        assert users.taken_j == pytest.approx(users.stored + heat_j, abs=1e-9)
    return users.f_s[0][0], users.f_s[0][5]


def test_a_silent_handle_that_is_turned_keeps_its_grip_and_one_that_felt_no_torque_turns():
    """With one brake it holds a torque with the force's strength, then its grip slides off (the
    control).
    """
    one = ((1.0,) * 6,)
    for turns in (0.0, 1.0, 12.0):
        force, torque = twisted(turns)
        assert force == pytest.approx(2.0, rel=0.01)
        assert torque == pytest.approx(-0.5 * turns, abs=1e-3)  # shared by two dampers b
    assert twisted(1.0, brakes=one)[1] < -0.99
    assert twisted(12.0, brakes=one)[0] < 1.3


def brakes_given(matrix="", **given):
    text = {"master": {"impedance_matrix": matrix}} if matrix else {}
    scenario = parse_scenario({"name": "small", "duration_s": 1.0, **text, **given})
    return brakes_of(scenario.users, scenario)


def test_brakes_are_apart_on_the_strict_channel_where_no_matrix_couples_force_and_torque():
    rows = 20.0 * np.eye(6)
    rows[0, 1] = rows[1, 0] = 3.0
    for couples, brakes in ((False, groups_of(6)), (True, ((1.0,) * 6,))):
        rows[0, 5] = rows[5, 0] = 2.0 * couples
        assert brakes_given(text_of(rows), channel="strict", dof=6) == brakes
    assert brakes_given(channel="strict", dof=6) == groups_of(6)
    assert brakes_given(channel="strict", dof=3) == ((1.0,) * 3,)
    assert brakes_given(channel="plain", dof=6) == ((0.0,) * 6,)


@pytest.mark.parametrize(("max_torque", "share"), [(0.0, 1.0), (0.1, 0.25)])
def test_the_limit_of_a_torque_is_that_of_its_force_at_the_lever(max_torque, share):
    safety = SafetyParams(max_force=8.0, max_torque=max_torque)
    session = session_given(dof=6, server=ServerParams(lever_m=0.05))
    _, p = made_user(User("user1", side=-1, given_safety=safety), session, answer_tick=0)
    (force, one), (torque, found) = p.limits.groups
    assert (force, torque, one) == (BOTH[0][0], BOTH[1][0], 1.0)
    assert found == pytest.approx(share)
