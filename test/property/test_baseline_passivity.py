# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers without waves give out no more at their two ports than they took in, and more where
they keep no account.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.baseline_link import TICK_S, BaselineLink, M
from support.law_rigs import Port

from pmwvc_core.params import BaselineParams, MasterParams
from pmwvc_core.params.server import PspmParams, TdpaParams, VirtualCouplingParams

ROUNDING_J = 1e-9
seeds = st.integers(0, 2**32 - 1)
delays = st.integers(0, 8)
losses = st.floats(0.0, 0.6)
stiffnesses = st.floats(0.0, 5000.0)


def link_of(controller, seed, delay, loss, **rest):
    rng = np.random.default_rng(seed)
    link = BaselineLink(
        controller, delay_frames=delay, lost=lambda *_: rng.random() < loss, **rest
    )
    return link, rng


def wander(rng, frames, *, speed=0.1):
    """Velocities, one row a frame: a random walk that turns back."""
    xd = 0.0
    for _ in range(frames):
        row = []
        for _ in range(M):
            xd = 0.98 * xd + rng.normal(0.0, 0.2 * speed)
            row.append(xd)
        yield row


def bounce(frames, *, hz=5.0, amplitude=0.01):
    """A device swung into a spring and out, one row a frame."""
    t = TICK_S * np.arange(frames * M + 1)
    x = amplitude * np.sin(2 * np.pi * hz * t)
    return (np.diff(x) / TICK_S).reshape(frames, M).tolist()


def here(link):
    """Return what the controller keeps at the device: its observer, or spring and tank."""
    law = link.master.s.law
    return law.spring if hasattr(law, "spring") else law.observer


def there(link):
    """Return the same at the avatar."""
    return link.server.s.ports[0].brake


class TestTimeDomainPassivity:
    @settings(max_examples=60)
    @given(seeds, delays, losses, stiffnesses, st.floats(0.0, 1.0))
    def test_the_link_never_gives_out_more_than_it_took_in(
        self, seed, delay, loss, stiffness, drift
    ):
        params = TdpaParams(damping=0.0, damping_max=1e12, fade_s=0.0, drift_share=drift)
        link, rng = link_of(
            "tdpa", seed, delay, loss, stiffness=stiffness, baseline=BaselineParams(tdpa=params)
        )
        for row in wander(rng, 60):
            link.frame(row)
            assert link.balance >= -ROUNDING_J
            assert there(link).allowance_j >= -ROUNDING_J

    @settings(max_examples=30)
    @given(seeds, delays, losses, st.floats(5.0, 500.0))
    def test_a_limited_damper_falls_short_by_what_the_limit_leaves(self, seed, delay, loss, most):
        """In a tick F xd h - a xd^2 h is at most F^2 h/(4 a)."""
        params = TdpaParams(damping=0.0, damping_max=most)
        link, rng = link_of("tdpa", seed, delay, loss, baseline=BaselineParams(tdpa=params))
        short = 0.0
        for row in wander(rng, 60):
            link.frame(row)
            held = link.master.s.law.force[0]
            short += M * held**2 * TICK_S / (4.0 * most)
            assert link.balance >= -short - ROUNDING_J

    @settings(max_examples=30)
    @given(seeds, delays, losses)
    def test_what_safety_takes_away_is_not_counted_as_given(self, seed, delay, loss):
        params = TdpaParams(damping_max=1e12, fade_s=0.0)
        link, rng = link_of("tdpa", seed, delay, loss, baseline=BaselineParams(tdpa=params))
        for row in wander(rng, 60):
            gain = rng.random()
            link.frame(row, change=lambda f, gain=gain: gain * f)
            assert there(link).allowance_j >= -ROUNDING_J
            assert there(link).out_j <= here(link).in_j + ROUNDING_J

    @settings(max_examples=30)
    @given(seeds, st.floats(1e-6, 1e-4))
    def test_work_is_that_of_the_force_held_over_its_own_way(self, seed, step_m):
        """On an encoder the velocity at a tick is that of the way before: booking with it (the
        control) counts energy that nobody gave.
        """
        rng = np.random.default_rng(seed)
        params = TdpaParams(damping=0.0, damping_max=25.0)
        master = Port(
            MasterParams(rate_drop=M), controller="tdpa", baseline=BaselineParams(tdpa=params)
        )
        path = np.cumsum(rng.normal(0.0, 3e-5, 400))
        shown = (step_m * np.round(path / step_m)).tolist()
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

    def test_without_the_controllers_the_same_swing_makes_energy(self):
        """The control: the same force and motion, and nobody who counts."""
        direct, observed = BaselineLink("direct"), BaselineLink("tdpa")
        for row in bounce(125):
            direct.frame(row)
            observed.frame(row)
        assert direct.balance < -0.01
        assert observed.balance > -1e-4


class TestSetPositionModulation:
    @settings(max_examples=60)
    @given(seeds, delays, losses, stiffnesses, st.floats(100.0, 3000.0), st.floats(0.0, 0.05))
    def test_no_end_gives_out_more_than_it_had_took_in_and_received(
        self, seed, delay, loss, contact, stiffness, initial
    ):
        params = PspmParams(
            stiffness=stiffness, damping=0.51 * stiffness * TICK_S, initial_j=initial
        )
        link, rng = link_of(
            "pspm", seed, delay, loss, stiffness=contact, baseline=BaselineParams(pspm=params)
        )
        for row in wander(rng, 60):
            link.frame(row)
            one, other = here(link), there(link)
            assert one.tank_j >= -ROUNDING_J and other.tank_j >= -ROUNDING_J
            assert link.balance >= -2.0 * initial - ROUNDING_J
            assert one.received_j <= other.sent_j and other.received_j <= one.sent_j

    @settings(max_examples=30)
    @given(seeds, delays, losses)
    def test_work_tank_and_spring_add_up_whatever_safety_does(self, seed, delay, loss):
        link, rng = link_of("pspm", seed, delay, loss)
        for row in wander(rng, 60):
            gain = 2.0 * rng.random()
            link.frame(row, change=lambda f, gain=gain: gain * f)
            for end, work in ((here(link), link.work_m), (there(link), link.work_s)):
                held = end.spring_j + end.tank_j - 0.02 + end.sent_j + end.dropped_j
                assert work + end.received_j == pytest.approx(held, abs=ROUNDING_J)

    def test_set_points_that_jump_for_nothing_make_energy(self):
        """The control: the same spring with a tank that never runs out."""
        endless = PspmParams(stiffness=500.0, damping=0.3, initial_j=1e6, cap_j=1e6)
        free = BaselineLink("pspm", baseline=BaselineParams(pspm=endless), delay_frames=4)
        spent = PspmParams(stiffness=500.0, damping=0.3)
        paid = BaselineLink("pspm", baseline=BaselineParams(pspm=spent), delay_frames=4)
        for row in bounce(125, hz=10.0):
            free.frame(row)
            paid.frame(row)
            assert paid.balance >= -0.04 - ROUNDING_J
        assert free.balance < -0.5
        assert paid.balance < -0.03  # what it began with is spent

    def test_a_spring_too_stiff_for_its_tick_overdraws_the_tank(self):
        """The control of B > K T_c/2."""
        params = PspmParams(stiffness=4000.0, damping=0.2, initial_j=0.0)
        link = BaselineLink("pspm", baseline=BaselineParams(pspm=params), delay_frames=0)
        lowest = 0.0
        for row in bounce(50):
            link.frame(row)
            lowest = min(lowest, here(link).tank_j)
        assert lowest < -1e-4


class TestVirtualCoupling:
    def test_late_spring_without_an_account_generates_energy(self):
        params = VirtualCouplingParams(stiffness=300.0, damping=0.0)
        late = BaselineLink(
            "virtual_coupling", baseline=BaselineParams(virtual_coupling=params), delay_frames=4
        )
        for row in bounce(125, hz=10.0):
            late.frame(row)
        assert late.balance < -0.3
