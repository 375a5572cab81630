# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's port emits no more energy than it receives, however safety changes the force."""

import dataclasses

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pmwvc_core.master.port import WaveMaster
from pmwvc_core.master.safety.limiter import SafetyLimiter
from pmwvc_core.numeric import dot, squared
from pmwvc_core.params import FilterParams, MasterParams, SafetyParams

TICK_S = 0.001
M = 8
impedances = st.floats(0.5, 200.0)
shapes = st.sampled_from(["float", (2,), (3, 1), (2, 3)])
seeds = st.integers(0, 2**32 - 1)
limits = st.builds(
    SafetyParams,
    max_force=st.floats(0.05, 20.0),
    max_slew=st.floats(1.0, 20000.0),
    soft_start_s=st.floats(0.01, 0.2),
    damper_velocity=st.floats(0.1, 1.0),
    fault_velocity=st.floats(1.1, 3.0),
)


class Account:
    """The port's energy account: what it got less what it emitted, from its signals alone."""

    def __init__(self, impedance, *, kind="none", hold="foh"):
        self.port = WaveMaster(
            MasterParams(
                impedance=impedance, rate_drop=M, hold=hold, filter=FilterParams(kind=kind)
            )
        )
        self.balance = 0.0
        self.unpaid = 0.0  # as balance, had the wave not been shortened

    def tick(self, xd, change):
        """Run a tick in which ``change`` makes the force applied from the force asked for."""
        port = self.port
        asked = port.step(xd, xd)
        natural = port.u_m
        applied = change(asked)
        port.applied(applied)
        got = squared(port.v_m) / 2 + dot(applied, xd)
        self.balance = self.balance + TICK_S * (got - squared(port.u_m) / 2)
        self.unpaid = self.unpaid + TICK_S * (got - squared(natural) / 2)
        return natural, asked, applied


def draw(shape, rng, scale):
    value = rng.normal(0.0, scale, None if shape == "float" else shape)
    return float(value) if shape == "float" else value


def tolerance(account):
    return 1e-12 * (1.0 + np.max(account.port.energy_v_m) + np.max(account.port.energy_u_m))


@given(impedances, shapes, seeds, st.floats(0.01, 30.0))
def test_any_force_at_all_is_paid_for(impedance, shape, seed, force):
    """At every tick: emitted <= received, but for what the force itself gave away (the debt)."""
    account, rng = Account(impedance), np.random.default_rng(seed)
    for tick in range(80):
        if tick % M == 0:
            account.port.receive(draw(shape, rng, 1.0))
        account.tick(draw(shape, rng, 0.3), lambda asked: draw(shape, rng, force))
        assert np.all(account.balance + account.port.deficit_j >= -tolerance(account))
        assert np.all(account.port.deficit_j >= 0.0)


@given(impedances, shapes, seeds)
def test_a_force_that_is_only_made_smaller_never_makes_a_debt(impedance, shape, seed):
    account, rng = Account(impedance), np.random.default_rng(seed)
    for tick in range(80):
        if tick % M == 0:
            account.port.receive(draw(shape, rng, 1.0))
        share = rng.uniform(0.0, 1.0)
        account.tick(draw(shape, rng, 0.3), lambda asked, share=share: share * asked)
        assert np.all(account.balance >= -tolerance(account))
        assert np.all(account.port.deficit_j <= tolerance(account))


def test_control_without_shortening_a_smaller_force_creates_energy():
    account = Account(25.0)
    for _ in range(100):
        account.port.receive(0.0)
        account.tick(0.2, lambda asked: 0.5 * asked)
    assert account.balance >= -1e-15
    assert account.unpaid < -0.04  # half of b xd^2 over 0.1 s


@given(impedances, shapes, seeds)
def test_an_untouched_force_leaves_the_wave_bit_for_bit(impedance, shape, seed):
    account, rng = Account(impedance), np.random.default_rng(seed)
    for tick in range(40):
        if tick % M == 0:
            account.port.receive(draw(shape, rng, 1.0))
        natural, _, _ = account.tick(draw(shape, rng, 0.3), lambda asked: asked + 0.0)
        assert np.all(account.port.u_m == natural)
    assert np.all(np.abs(account.balance) <= tolerance(account))


@settings(max_examples=50)  # each of 300 ticks
@given(impedances, shapes, seeds, limits, st.sampled_from([0.05, 0.5, 2.0]))
def test_the_limits_themselves_are_paid_for(impedance, shape, seed, params, speed):
    account, rng = Account(impedance), np.random.default_rng(seed)
    safety = SafetyLimiter(params, tick_s=TICK_S, packet_s=0.008)
    xd = draw(shape, rng, speed)
    for tick in range(300):
        if tick % M == 0:
            account.port.receive(draw(shape, rng, 1.0))
        xd = 0.97 * xd + 0.2 * draw(shape, rng, speed)
        silence_s = 0.05 if 100 <= tick < 180 else 0.0
        account.tick(
            xd,
            lambda asked, xd=xd, silence_s=silence_s: safety.step(
                asked, xd, xd, silence_s=silence_s, coupled=True
            ),
        )
        assert np.all(account.balance + account.port.deficit_j >= -tolerance(account))


@given(
    impedances,
    shapes,
    seeds,
    limits,
    st.lists(st.tuples(st.integers(1, 40), st.integers(1, 80)), min_size=1, max_size=6),
)
def test_stalls_of_any_length_are_paid_for_and_make_no_step(
    impedance, shape, seed, params, stalls
):
    """Silence and answers in turn, from a tick to far beyond the time the force fades in."""
    account, rng = Account(impedance), np.random.default_rng(seed)
    safety = SafetyLimiter(params, tick_s=TICK_S, packet_s=0.008)
    quiet = [t for there, gone in stalls for t in [0] * there + list(range(25, 25 + gone))]
    xd, before = draw(shape, rng, 0.1), 0.0
    for tick, silent_ticks in enumerate(quiet):
        if tick % M == 0 and not silent_ticks:
            account.port.receive(draw(shape, rng, 1.0))
        xd = 0.97 * xd + 0.2 * draw(shape, rng, 0.1)
        _, _, force = account.tick(
            xd,
            lambda asked, xd=xd, silence_s=silent_ticks * TICK_S: safety.step(
                asked, xd, xd, silence_s=silence_s, coupled=True
            ),
        )
        assert np.all(account.balance + account.port.deficit_j >= -tolerance(account))
        change = np.max(np.sqrt(squared(force - before)))
        assert change <= params.max_slew * TICK_S * (1 + 1e-9) + 1e-12
        before = force


@settings(max_examples=50)
@given(shapes, seeds, limits)
def test_an_impedance_that_changes_while_it_runs_is_paid_for_over_its_whole_range(
    shape, seed, params
):
    account, rng = Account(25.0), np.random.default_rng(seed)
    safety = SafetyLimiter(params, tick_s=TICK_S, packet_s=0.008)
    xd = draw(shape, rng, 0.2)
    for tick in range(300):
        if tick % M == 0:
            port = account.port
            wanted = float(10.0 ** rng.uniform(-2.0, 3.0))
            port.configure(dataclasses.replace(port.params, impedance=wanted))
            port.receive(draw(shape, rng, 1.0))
        xd = 0.97 * xd + 0.2 * draw(shape, rng, 0.2)
        account.tick(
            xd, lambda asked, xd=xd: safety.step(asked, xd, xd, silence_s=0.0, coupled=True)
        )
        assert np.all(account.balance + account.port.deficit_j >= -tolerance(account))


def test_a_debt_is_kept_back_from_later_waves():
    account = Account(25.0)
    account.port.receive(0.0)
    account.tick(-0.2, lambda asked: 3.0)  # an old force pushes along: 0.6 W given away
    assert account.port.deficit_j > 0.0 and account.port.u_m == 0.0
    ticks = 0
    while account.port.deficit_j > 0.0:
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
    safety = SafetyLimiter(params, tick_s=TICK_S, packet_s=0.008)
    port, rng, taken = account.port, np.random.default_rng(seed), 0.0
    xd = 0.0
    for _ in range(60):
        port.send()
        slack = tolerance(account)
        assert port.energy_u_tx <= port.energy_v_rx + taken + port.deficit_j + slack
        port.receive(float(rng.normal(0.0, 1.0)))
        for _ in range(M):
            xd = 0.97 * xd + float(rng.normal(0.0, 0.05))
            _, _, f = account.tick(
                xd, lambda asked, xd=xd: safety.step(asked, xd, xd, silence_s=0.0, coupled=True)
            )
            taken += TICK_S * f * xd
