# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's port emits no more energy than it receives, however safety changes the force."""

import dataclasses

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import ForceLimits, Port

from pmwvc_core.ends.inbox import value
from pmwvc_core.params import FilterParams, MasterParams

TICK_S = 0.001
M = 8
impedances = st.floats(0.5, 200.0)
numbers_of_axes = st.integers(1, 3)
seeds = st.integers(0, 2**32 - 1)
limits = st.fixed_dictionaries(
    {
        "max_force": st.floats(0.05, 20.0),
        "max_slew": st.floats(1.0, 20000.0),
        "soft_start_s": st.floats(0.01, 0.2),
        "damper_velocity": st.floats(0.1, 1.0),
        "fault_velocity": st.floats(1.1, 3.0),
    }
)


class Account:
    """The port's energy account: what it got less what it emitted, from its signals alone."""

    def __init__(self, impedance, *, axes=1, kind="none", hold="foh"):
        self.params = MasterParams(
            impedance=impedance, rate_drop=M, hold=hold, filter=FilterParams(kind=kind)
        )
        self.port = Port(self.params, axes=axes)
        self.balance = 0.0
        self.unpaid = 0.0  # as balance, had the wave not been shortened

    def tick(self, xd, change):
        """Run a tick in which ``change`` makes the force applied from the force asked for."""
        port = self.port
        asked = port.step(xd, xd)
        natural = port.u_m
        applied = change(asked)
        port.applied(applied)
        got = np.dot(port.v_m, port.v_m) / 2 + np.dot(applied, xd)
        self.balance += TICK_S * (got - np.dot(port.u_m, port.u_m) / 2)
        self.unpaid += TICK_S * (got - np.dot(natural, natural) / 2)
        return natural, applied

    def limited(self, xd, safety, silence_s=0.0):
        """Run a tick with these limits; return the force applied."""
        return self.tick(xd, lambda asked: safety(asked, xd, x=xd, silence_s=silence_s))[1]

    @property
    def deficit_j(self):
        return self.port.s.deficit_j

    @property
    def tolerance(self):
        s = self.port.s
        return 1e-12 * (1.0 + s.v_m_j + s.u_m_j)


def draw(axes, rng, scale):
    return value(tuple(rng.normal(0.0, scale, axes).tolist()))


@given(impedances, numbers_of_axes, seeds, st.floats(0.01, 30.0))
def test_any_force_at_all_is_paid_for(impedance, axes, seed, force):
    """At every tick: emitted <= received, but for what the force itself gave away (the debt)."""
    account, rng = Account(impedance, axes=axes), np.random.default_rng(seed)
    for tick in range(80):
        if tick % M == 0:
            account.port.receive(draw(axes, rng, 1.0))
        account.tick(draw(axes, rng, 0.3), lambda asked: draw(axes, rng, force))
        assert account.balance + account.deficit_j >= -account.tolerance
        assert account.deficit_j >= 0.0


@given(impedances, numbers_of_axes, seeds)
def test_a_force_that_is_only_made_smaller_never_makes_a_debt(impedance, axes, seed):
    account, rng = Account(impedance, axes=axes), np.random.default_rng(seed)
    for tick in range(80):
        if tick % M == 0:
            account.port.receive(draw(axes, rng, 1.0))
        share = rng.uniform(0.0, 1.0)
        account.tick(draw(axes, rng, 0.3), lambda asked, share=share: share * asked)
        assert account.balance >= -account.tolerance
        assert account.deficit_j <= account.tolerance


def test_control_without_shortening_a_smaller_force_creates_energy():
    account = Account(25.0)
    for _ in range(100):
        account.port.receive(0.0)
        account.tick(0.2, lambda asked: 0.5 * asked)
    assert account.balance >= -1e-15
    assert account.unpaid < -0.04  # half of b xd^2 over 0.1 s


@given(impedances, numbers_of_axes, seeds)
def test_an_untouched_force_leaves_the_wave_bit_for_bit(impedance, axes, seed):
    account, rng = Account(impedance, axes=axes), np.random.default_rng(seed)
    for tick in range(40):
        if tick % M == 0:
            account.port.receive(draw(axes, rng, 1.0))
        natural, _ = account.tick(draw(axes, rng, 0.3), lambda asked: asked + 0.0)
        assert np.all(account.port.u_m == natural)
    assert abs(account.balance) <= account.tolerance


@settings(max_examples=50)  # each of 300 ticks
@given(impedances, numbers_of_axes, seeds, limits, st.sampled_from([0.05, 0.5, 2.0]))
def test_the_limits_themselves_are_paid_for(impedance, axes, seed, params, speed):
    account, rng = Account(impedance, axes=axes), np.random.default_rng(seed)
    safety = ForceLimits(axes=axes, **params)
    xd = draw(axes, rng, speed)
    for tick in range(300):
        if tick % M == 0:
            account.port.receive(draw(axes, rng, 1.0))
        xd = 0.97 * xd + 0.2 * draw(axes, rng, speed)
        silence_s = 0.05 if 100 <= tick < 180 else 0.0
        account.limited(xd, safety, silence_s)
        assert account.balance + account.deficit_j >= -account.tolerance


@given(
    impedances,
    numbers_of_axes,
    seeds,
    limits,
    st.lists(st.tuples(st.integers(1, 40), st.integers(1, 80)), min_size=1, max_size=6),
)
def test_stalls_of_any_length_are_paid_for_and_make_no_step(impedance, axes, seed, params, stalls):
    """Silence and answers in turn, from a tick to far beyond the time the force fades in."""
    account, rng = Account(impedance, axes=axes), np.random.default_rng(seed)
    safety = ForceLimits(axes=axes, **params)
    quiet = [t for there, gone in stalls for t in [0] * there + list(range(25, 25 + gone))]
    xd, before = draw(axes, rng, 0.1), 0.0
    for tick, silent_ticks in enumerate(quiet):
        if tick % M == 0 and not silent_ticks:
            account.port.receive(draw(axes, rng, 1.0))
        xd = 0.97 * xd + 0.2 * draw(axes, rng, 0.1)
        force = account.limited(xd, safety, silent_ticks * TICK_S)
        assert account.balance + account.deficit_j >= -account.tolerance
        change = np.linalg.norm(force - before)
        assert change <= params["max_slew"] * TICK_S * (1 + 1e-9) + 1e-12
        before = force


@settings(max_examples=50)
@given(numbers_of_axes, seeds, limits)
def test_an_impedance_that_changes_while_it_runs_is_paid_for_over_its_whole_range(
    axes, seed, params
):
    account, rng = Account(25.0, axes=axes), np.random.default_rng(seed)
    safety = ForceLimits(axes=axes, **params)
    xd = draw(axes, rng, 0.2)
    for tick in range(300):
        if tick % M == 0:
            port = account.port
            wanted = float(10.0 ** rng.uniform(-2.0, 3.0))
            port.configure(dataclasses.replace(account.params, impedance=wanted))
            port.receive(draw(axes, rng, 1.0))
        xd = 0.97 * xd + 0.2 * draw(axes, rng, 0.2)
        account.limited(xd, safety)
        assert account.balance + account.deficit_j >= -account.tolerance


def test_a_debt_is_kept_back_from_later_waves():
    account = Account(25.0)
    account.port.receive(0.0)
    account.tick(-0.2, lambda asked: 3.0)  # an old force pushes along: 0.6 W given away
    assert account.deficit_j > 0.0 and account.port.u_m == 0.0
    ticks = 0
    while account.deficit_j > 0.0:
        account.tick(0.1, lambda asked: asked)  # the hand puts 0.25 W in
        ticks += 1
    assert ticks == 3
    account.tick(0.1, lambda asked: asked)
    assert account.balance >= -1e-15
    assert account.port.u_m == np.sqrt(50.0) * 0.1


@given(impedances, seeds, limits, st.sampled_from(["zoh", "foh"]))
def test_packets_carry_no_more_than_packets_and_hand_brought(impedance, seed, params, hold):
    """From packet to packet, with integrate-and-dump, at every frame end."""
    account = Account(impedance, kind="integrate_and_dump", hold=hold)
    safety = ForceLimits(**params)
    port, rng, taken = account.port, np.random.default_rng(seed), 0.0
    xd = 0.0
    for _ in range(60):
        port.send()
        brought = port.s.v_rx_j + taken + account.deficit_j
        assert port.s.u_tx_j <= brought + account.tolerance
        port.receive(float(rng.normal(0.0, 1.0)))
        for _ in range(M):
            xd = 0.97 * xd + float(rng.normal(0.0, 0.05))
            f = account.limited(xd, safety)
            taken += TICK_S * f * xd
