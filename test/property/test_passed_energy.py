# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A playout that passes surplus on gives out and passes no more than arrived, at any instant; and
in a wave that varies slowly no gap of any length is a blow: not in it, at its end, or while what
was lost is made up.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.receiving import Playing

from pmwvc_core.law.channel import playout as law
from pmwvc_core.law.channel.constants import TANK_J
from pmwvc_core.law.channel.playout import FEW, MOST_J
from pmwvc_core.numeric import squared

STEP_S, PERIOD_S, ROUNDING = 0.004, 0.008, 1e-12
schedules = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 2**32 - 1),
        "dof": st.integers(1, 6),
        "paid": st.sampled_from((0.3, 1.0, 5.0)),
        "steps": st.lists(st.sampled_from((0, 1, 2, 2, 2, 3, 30)), min_size=1, max_size=8),
    }
)


class Passing(Playing):
    """A playout of which energy is wanted at times; what it gave out and passed on."""

    passed_j = 0.0

    def play(self, wanted):
        wave = self.step(STEP_S)
        self.passed_j = self.passed_j + self.spared(STEP_S, wanted)
        return wave


class Generous(Passing):
    """The control: passes on what free energy it sees, and forgets it."""

    def spared(self, h, wanted):
        return max(self.free_j, 0.0) * wanted


def run(playout, schedule, wants=True):
    """Yield the wave of every step, and what it would be where nothing is passed on."""
    rng = np.random.default_rng(schedule["seed"])
    alone = Playing(schedule["dof"])
    for k in range(40):
        wave = drawn(rng, schedule)
        energy = schedule["paid"] * rng.random() * squared(wave) * PERIOD_S
        for each in (playout, alone):
            each.add(wave * PERIOD_S, energy, PERIOD_S)
        for _ in range(schedule["steps"][k % len(schedule["steps"])]):
            wanted = rng.random() < 0.5
            yield playout.play(wanted & wants), alone.step(STEP_S)


def drawn(rng, schedule):
    wave = rng.normal(size=schedule["dof"])
    return wave if schedule["dof"] > 1 else float(wave[0])


@settings(max_examples=15)
@given(schedule=schedules)
def test_given_and_passed_are_no_more_than_arrived(schedule):
    playout = Passing(schedule["dof"])
    for _ in run(playout, schedule):
        out = playout.given_j + playout.passed_j
        assert out <= playout.received_j * (1.0 + ROUNDING)


def test_whoever_passes_on_what_is_not_free_gives_out_more_than_arrived():
    schedule = {"seed": 2, "dof": 2, "paid": 5.0, "steps": [2]}
    for kind, passive in ((Passing, True), (Generous, False)):
        playout, least = kind(2), 0.0
        for _ in run(playout, schedule):
            least = min(least, playout.received_j - playout.given_j - playout.passed_j)
        assert playout.passed_j > 0.05
        assert (least > -ROUNDING) is passive


@settings(max_examples=10)
@given(schedule=schedules)
def test_nothing_is_passed_on_that_nobody_wants(schedule):
    playout = Passing(schedule["dof"])
    for own, alone in run(playout, schedule, wants=False):
        np.testing.assert_array_equal(own, alone)
    assert playout.passed_j == 0.0


@settings(max_examples=15)
@given(
    schedule=schedules, missed=st.lists(st.sampled_from((0.0, 0.0, 0.004, 0.1, 2.0)), min_size=1)
)
def test_a_loop_that_stands_still_gives_out_no_more_and_loses_no_motion(schedule, missed):
    rng = np.random.default_rng(schedule["seed"])
    playout, arrived, given_out = Playing(schedule["dof"]), 0.0, 0.0
    for k in range(60):
        wave = drawn(rng, schedule)
        playout.add(wave * PERIOD_S, schedule["paid"] * 0.5 * squared(wave) * PERIOD_S, PERIOD_S)
        arrived = arrived + wave * PERIOD_S
        playout.pass_by(missed[k % len(missed)])
        for _ in range(schedule["steps"][k % len(schedule["steps"])]):
            given_out = given_out + playout.step(STEP_S) * STEP_S
        assert playout.given_j <= playout.received_j * (1.0 + ROUNDING)
        np.testing.assert_allclose(given_out + playout.waiting, arrived, atol=1e-12)


WAVE, SLIP, LONG_S = 0.3, 0.2, 0.5


def after_an_outage(steps, energy=0.2, **of_playout):
    """A playout that was dry for 0.5 s, then got a displacement and its energy; steps later."""
    playout, wave = Playing(**of_playout), WAVE
    playout.add(wave * PERIOD_S, 0.5 * wave**2 * PERIOD_S, PERIOD_S)
    for _ in range(125):
        playout.step(STEP_S)
    playout.add(SLIP, energy, LONG_S)
    for k in range(steps):
        if k % 2 == 0:
            playout.add(wave * PERIOD_S, 0.5 * wave**2 * PERIOD_S, PERIOD_S)
        playout.step(STEP_S)
    return playout


def test_what_an_outage_brought_is_kept_until_the_displacement_is_made_up(monkeypatch):
    begun, ended = after_an_outage(10), after_an_outage(300)
    assert begun.undelivered > 0.19 and begun.free_j > 3.0 * MOST_J
    assert begun.discarded_j == 0.0
    assert ended.undelivered < FEW and ended.free_j <= MOST_J + ROUNDING
    assert ended.discarded_j > 0.0
    monkeypatch.setattr(law, "FEW", np.inf)  # the control: capped at once
    assert after_an_outage(10).discarded_j > 2.0 * MOST_J


def test_a_slip_is_made_up_as_fast_as_what_was_paid_for_it_beyond_the_present_wave_allows():
    for price in (0.45, 0.5):  # E/D; the wave costs WAVE for each part of D
        begun, later = (after_an_outage(steps, price * SLIP) for steps in (75, 100))
        speed = (begun.undelivered - later.undelivered) / (25 * STEP_S)
        assert speed == pytest.approx(2.0 * (price - WAVE), rel=0.05)
        assert after_an_outage(600, price * SLIP).undelivered < FEW
    rest = after_an_outage(2500, 0.8 * WAVE * SLIP)  # ten seconds later
    assert rest.undelivered > 0.1 * SLIP and rest.free_j < 1e-3


TICK_S, TICKS, WAVE = 0.001, 8, 0.23  # 1.6 N at b = 25 N s/m
PACKET_S = TICKS * TICK_S
FELT = 0.25 * WAVE  # the change within a tick


def largest_change(seed, store_j, frames=200):
    """Return the largest change of the wave within a tick, with gaps of up to 16 packets."""
    lends = {"store_j": store_j, "keep_j": TANK_J - store_j}
    playout, waves = Playing(steps=TICKS, most_repaid=0.5, **lends), []
    rng = np.random.default_rng(seed)
    lost, waited, integral, paid_j = 0, 0, 0.0, 0.0
    for frame in range(frames):
        wave = WAVE * (1.0 + 0.3 * np.sin(np.pi * frame * PACKET_S))
        integral, paid_j = integral + wave * PACKET_S, paid_j + 0.5 * wave**2 * PACKET_S
        waited += 1
        if lost == 0 and frame > 30 and rng.random() < 0.06:
            lost = int(rng.integers(1, 17))
        if lost:
            lost -= 1
        else:
            playout.add(integral, paid_j, waited * PACKET_S)
            waited, integral, paid_j = 0, 0.0, 0.0
        waves += [playout.step(TICK_S) for _ in range(TICKS)]
        assert playout.given_j <= playout.received_j + store_j + 1e-12
    return float(np.abs(np.diff(waves[30 * TICKS :])).max())


@given(seed=st.integers(0, 2**32 - 1), store_j=st.sampled_from([TANK_J, 0.01]))
@settings(max_examples=12)
def test_no_gap_is_felt_as_a_blow(seed, store_j):
    assert largest_change(seed, store_j) < FELT


def test_with_nothing_to_lend_a_gap_is_a_blow():
    """The control."""
    assert all(largest_change(seed, 0.0) > FELT for seed in range(5))
