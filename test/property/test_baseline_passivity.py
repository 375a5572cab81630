# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers without waves give out no more at their two ports than they took in, and more where
they keep no account.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.baseline_link import FRAME_S, TICK_S, BaselineLink, M
from support.port_rig import Port

from pmwvc_core.law.without_waves.tdpa import Observer, overdraft_j
from pmwvc_core.params import BaselineParams, MasterParams
from pmwvc_core.params.server import PspmParams, TdpaParams, VirtualCouplingParams

ROUNDING_J = 1e-9
seeds = st.integers(0, 2**32 - 1)
networks = st.tuples(st.integers(0, 8), st.floats(0.0, 0.6))  # delay in frames, losses
stiffnesses = st.floats(0.0, 5000.0)


def link_of(controller, params, *, seed=0, network=(2, 0.0), **rest):
    delay, loss = network
    rng = np.random.default_rng(seed)
    baseline = BaselineParams(**{controller: params}) if params else None
    return BaselineLink(
        controller,
        baseline=baseline,
        delay_frames=delay,
        lost=lambda *_: rng.random() < loss,
        **rest,
    )


def wander(link, seed, *, most=None, frames=60, speed=0.1):
    """Run a random walk that turns back; yield after each frame. What is asked for is changed by a
    gain of up to ``most`` in every frame.
    """
    rng, xd = np.random.default_rng(seed + 1), 0.0
    for _ in range(frames):
        row = []
        for _ in range(M):
            xd = 0.98 * xd + rng.normal(0.0, 0.2 * speed)
            row.append(xd)
        gain = 1.0 if most is None else most * rng.random()
        link.frame(row, change=lambda f, gain=gain: gain * f)
        yield link.master.s.law, link.server.s.ports[0].brake


def least(link, frames=125, *, hz=10.0, amplitude=0.01):
    """Swing a device into a spring and out; return the least balance and that at the end [J]."""
    t = TICK_S * np.arange(frames * M + 1)
    motion = np.diff(amplitude * np.sin(2 * np.pi * hz * t)) / TICK_S
    found = []
    for row in motion.reshape(frames, M).tolist():
        link.frame(row)
        found.append(link.balance)
    return min(found), found[-1]


@settings(max_examples=20)
@given(seeds, networks, stiffnesses, st.floats(0.0, 1.0), st.one_of(st.none(), st.just(1.0)))
def test_observers_never_give_out_more_than_they_took_in(seed, network, stiffness, drift, most):
    """What safety takes away is not counted as given."""
    params = TdpaParams(damping=0.0, damping_max=1e12, fade_s=0.0, drift_share=drift)
    link = link_of("tdpa", params, seed=seed, network=network, stiffness=stiffness)
    for here, there in wander(link, seed, most=most):
        assert link.balance >= -ROUNDING_J or most
        assert there.observer.allowance_j >= -ROUNDING_J
        assert there.observer.out_j <= here.observer.in_j + ROUNDING_J


@settings(max_examples=15)
@given(seeds, networks, st.floats(5.0, 500.0))
def test_a_limited_damper_falls_short_by_what_the_limit_leaves(seed, network, most):
    """In a tick F xd h - a xd^2 h is at most F^2 h/(4 a)."""
    params = TdpaParams(damping=0.0, damping_max=most)
    link, short = link_of("tdpa", params, seed=seed, network=network), 0.0
    for here, _ in wander(link, seed):
        short += M * here.force[0] ** 2 * TICK_S / (4.0 * most)
        assert link.balance >= -short - ROUNDING_J


def test_what_the_observer_at_the_avatar_takes_is_booked():
    """Without it the force would have given out what the device's velocity asks for."""
    params = TdpaParams(damping=0.0, damping_max=1e12, drift_share=0.0)
    link, wanted_j = link_of("tdpa", params, seed=3), 0.0
    for _, end in wander(link, 3):
        there = end.observer
        if link.newest["up"] is not None:
            wanted_j += FRAME_S * link.server.f_s[0] * link.newest["up"].wave
        assert there.out_j - there.in_j + there.dissipated_j == pytest.approx(wanted_j, abs=1e-12)
    assert there.dissipated_j > 1e-6


def test_who_is_overdrawn_is_braked_also_where_the_force_takes_in():
    """What comes in here may be given out at the other end only."""
    assert overdraft_j(Observer(allowance_j=-0.2), -0.1) == 0.2
    assert overdraft_j(Observer(allowance_j=0.2), 0.3) == pytest.approx(0.1)


@settings(max_examples=20)
@given(seeds, st.floats(1e-6, 1e-4))
def test_work_is_that_of_the_force_held_over_its_own_way(seed, step_m):
    """On an encoder the velocity at a tick is that of the way before: booking with it (the
    control) counts energy that nobody gave.
    """
    rng = np.random.default_rng(seed)
    own = BaselineParams(tdpa=TdpaParams(damping=0.0, damping_max=25.0))
    master = Port(MasterParams(rate_drop=M), controller="tdpa", baseline=own)
    shown = (step_m * np.round(np.cumsum(rng.normal(0.0, 3e-5, 400)) / step_m)).tolist()
    done = early = force = before = 0.0
    for n, x in enumerate(shown):
        velocity = (x - before) / TICK_S
        done += force * (x - before)
        if n % M == 0:
            master.receive(float(rng.normal(0.0, 2.0)))
        force = master.step(x, velocity)
        master.applied(force)
        early += force * velocity * TICK_S
        before = x
    observer = master.s.law.observer
    booked = observer.in_j - observer.out_j + observer.dissipated_j
    assert booked == pytest.approx(done, abs=1e-12)
    assert abs(booked - early) > 1e-6


@settings(max_examples=20)
@given(seeds, networks, stiffnesses, st.floats(100.0, 3000.0), st.floats(0.0, 0.05), st.booleans())
def test_no_tank_gives_out_more_than_it_had_took_in_and_received(
    seed, network, contact, stiffness, initial, changed
):
    """Work, tank and spring add up at each end, whatever safety does."""
    params = PspmParams(stiffness=stiffness, damping=0.51 * stiffness * TICK_S, initial_j=initial)
    link = link_of("pspm", params, seed=seed, network=network, stiffness=contact)
    for one, other in wander(link, seed, most=2.0 if changed else None):
        for end, work in ((one, link.work_m), (other, link.work_s)):
            held = end.spring_j + end.tank_j - initial + end.sent_j + end.dropped_j
            assert work + end.received_j == pytest.approx(held, abs=ROUNDING_J)
        assert one.received_j <= other.sent_j and other.received_j <= one.sent_j
        if not changed:
            assert one.tank_j >= -ROUNDING_J and other.tank_j >= -ROUNDING_J
            assert link.balance >= -2.0 * initial - ROUNDING_J
    before = one.spring_j + one.dropped_j
    link.master.silence()
    after = link.master.s.law
    assert (after.spring_j, after.dropped_j) == (0.0, pytest.approx(before))


ENDLESS = PspmParams(stiffness=500.0, damping=0.3, initial_j=1e6, cap_j=1e6)
LATE_SPRING = VirtualCouplingParams(stiffness=300.0, damping=0.0)


@pytest.mark.parametrize(
    ("controller", "params", "hz", "delay", "lowest", "highest"),
    [
        ("tdpa", None, 5.0, 2, -1e-4, np.inf),
        ("direct", None, 5.0, 2, -np.inf, -0.01),  # the same force and motion, and nobody counts
        ("pspm", PspmParams(stiffness=500.0, damping=0.3), 10.0, 4, -0.04, -0.03),  # what it had
        ("pspm", ENDLESS, 10.0, 4, -np.inf, -0.5),  # set points that jump for nothing
        ("virtual_coupling", LATE_SPRING, 10.0, 4, -np.inf, -0.3),  # late, without an account
    ],
)
def test_controls_without_an_account_the_same_swing_makes_energy(
    controller, params, hz, delay, lowest, highest
):
    most_given, end = least(link_of(controller, params, network=(delay, 0.0)), hz=hz)
    assert most_given >= lowest - ROUNDING_J
    assert end < highest


def test_control_a_spring_too_stiff_for_its_tick_overdraws_the_tank():
    """B > K T_c/2 does not hold."""
    link = link_of(
        "pspm", PspmParams(stiffness=4000.0, damping=0.2, initial_j=0.0), network=(0, 0)
    )
    lowest = 0.0
    for row in (0.3 * np.cos(0.06 * np.arange(50 * M))).reshape(50, M).tolist():
        link.frame(row)
        lowest = min(lowest, link.master.s.law.tank_j)
    assert lowest < -1e-4
