# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A velocity filter returns no more energy than it received where its margin promises that, and
more where it does not.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.filter_runs import Stage
from support.law_rigs import Port
from support.port_parts import Part
from support.strategies import TICK_S

from pmwvc_core.ends.inbox import value
from pmwvc_core.params import FilterParams, MasterParams, VelocityFilterParams
from pmwvc_core.wave.aliasing import margins
from pmwvc_core.wave.velocity_filter_design import branches, chosen

POLE_RAD_S = float(-np.log(0.95) / TICK_S)  # 0.05/(z - 0.95), App. D Eq. 15
seeds = st.integers(0, 2**32 - 1)


def master(kind="exact", *, filtering=None, impedance=30.0, rate_drop=1, **numbers):
    return MasterParams(
        impedance=impedance,
        rate_drop=rate_drop,
        hold="zoh",
        filter=filtering or FilterParams(kind="first_order", pole_rad_s=POLE_RAD_S),
        velocity_filter=VelocityFilterParams(kind=kind, **numbers),
    )


meets_any_environment = st.builds(
    lambda pole, order, share: master(
        filtering=FilterParams(kind="first_order", pole_rad_s=pole), order=order, share=share
    ),
    st.floats(5.0, 100.0),
    st.integers(2, 4),
    st.floats(0.05, 0.75),
)


class AllPass:
    """R = s (a + 1/z)/(1 + a/z) of size ``size`` <= 1: a passive environment of any phase."""

    def __init__(self, a, size):
        self._a, self._size, self._state = a, size, 0.0

    def step(self, u):
        y = self._a * u + self._state
        self._state = u - self._a * y
        return self._size * y


class Modulator:
    """Turns its sign at every tick: passive, but what is slow comes back fast."""

    def __init__(self):
        self._sign = 1.0

    def step(self, u):
        self._sign = -self._sign
        return self._sign * u


class Channel:
    """Velocity filter, anti-aliasing filter and an environment at the tick rate.

    Without the device: any wave may go out. ``balance`` is the energy that stayed.
    """

    def __init__(self, params, environment):
        self.part = Part(params)
        self.filter = Stage(params.filter, rate_drop=1)
        self.environment = environment
        self.returned = 0.0
        self.balance = 0.0
        self.out = 0.0

    def step(self, u):
        v = self.part.down(self.returned)
        v = v + self.part.offer()(u)
        self.returned = self.environment.step(self.filter.step(self.part.step(u)))
        self.out += u * u
        self.balance += u * u - v * v
        return v


@given(
    meets_any_environment,
    st.floats(-0.99, 0.99),
    st.floats(-1.0, 1.0),
    seeds,
    st.sampled_from(["white", "slow", "sparse"]),
)
def test_with_the_margin_no_environment_makes_the_channel_active(params, a, size, seed, shape):
    rng = np.random.default_rng(seed)
    waves = rng.standard_normal(300)
    if shape == "slow":
        waves = np.cumsum(waves)
    elif shape == "sparse":
        waves = np.where(rng.random(300) < 0.03, 100.0 * waves, 0.0)
    channel = Channel(params, AllPass(a, size))
    for u in waves.tolist():
        channel.step(u)
        assert channel.balance >= -1e-7 * channel.out


def worst(params):
    """Return with which frequency [Hz] and reflection the branches give back most, and how much
    of the energy then stays.
    """
    whole = chosen(params)
    frequency = np.geomspace(0.05, 500.0, 4000)
    low, high = branches(whole, frequency)
    share = params.velocity_filter.share
    found = margins(low, high, frequency, share=share)
    place = int(np.argmax(found["any_environment"]))
    # The channel's environment answers a tick later.
    w = 2.0 * math.pi * frequency[place] * TICK_S
    turn = np.angle(high[place] / low[place]) + w
    for sign in (1.0, -1.0):
        # the angle of (a + 1/z)/(1 + a/z) runs from 0 (a = 1) to -pi (a = -1)
        wanted = (turn + (math.pi if sign < 0.0 else 0.0)) % (2.0 * math.pi) - 2.0 * math.pi
        if -math.pi < wanted < 0.0:
            low_a, high_a = -1.0, 1.0
            for _ in range(80):
                a = 0.5 * (low_a + high_a)
                angle = np.angle((a + np.exp(-1j * w)) / (1.0 + a * np.exp(-1j * w)))
                low_a, high_a = (low_a, a) if angle > wanted else (a, high_a)
            most = 1.0 - found["any_environment_margin"]
            return frequency[place], AllPass(a, sign), 1.0 - most**2
    raise AssertionError("no all-pass has this angle")


@pytest.mark.parametrize("alpha", [0.8, 0.929, 0.95])
def test_a_filter_without_the_margin_has_an_input_that_makes_it_active(alpha):
    """As much as its margin says; 0.929 is the printed filter."""
    params = master(order=1, alpha=alpha)
    frequency_hz, environment, stays = worst(params)
    channel = Channel(params, environment)
    for k in range(60_000):
        channel.step(math.sin(2.0 * math.pi * frequency_hz * TICK_S * k))
    assert stays < -0.01
    assert channel.balance < 0.6 * stays * channel.out  # what is stored counts against it


def test_the_same_search_finds_nothing_where_the_margin_holds():
    params = master(order=2, share=0.7)
    frequency_hz, environment, stays = worst(params)
    channel = Channel(params, environment)
    for k in range(60_000):
        channel.step(math.sin(2.0 * math.pi * frequency_hz * TICK_S * k))
        assert channel.balance >= -1e-7 * channel.out
    assert channel.balance / channel.out == pytest.approx(stays, abs=2e-3)


def test_control_an_environment_that_shifts_frequencies_defeats_the_margin_for_any_phase():
    channel = Channel(master(order=2, share=0.7), Modulator())
    for k in range(3000):
        channel.step(1.0 + 0.5 * (-1.0) ** k)
    other = Channel(master(order=2, share=0.7), Modulator())
    for k in range(3000):
        other.step(1.0 - 0.5 * (-1.0) ** k)
    assert min(channel.balance, other.balance) < -0.3 * channel.out


@given(
    order=st.integers(1, 3),
    share=st.floats(0.1, 1.0),
    cutoff_hz=st.floats(2.0, 200.0),
    seed=seeds,
    shape=st.sampled_from(["white", "slow", "alternating"]),
)
def test_the_complementary_filter_is_passive_by_itself(order, share, cutoff_hz, seed, shape):
    """Whatever goes in at either end, at every tick: kept energy >= 0."""
    params = master("complementary", order=order, share=share, cutoff_hz=cutoff_hz)
    part = Part(params)
    rng = np.random.default_rng(seed)
    waves = rng.standard_normal((200, 2))
    if shape == "slow":
        waves = np.cumsum(waves, axis=0)
    elif shape == "alternating":
        waves = np.abs(waves) * np.stack([np.ones(200), (-1.0) ** np.arange(200)], axis=1)
    for u, w in waves.tolist():
        part.down(w)
        part.offer()
        part.step(u)
        assert part.energies["velocity_filter"] >= -1e-9 * TICK_S * np.sum(waves**2)


@given(seeds, st.sampled_from(["exact", "complementary"]), st.sampled_from([1, 2]))
def test_any_force_at_all_is_paid_for_through_the_answer(seed, kind, axes):
    """The port emits no more than it gets, whatever safety makes of the force."""
    port, rng = Port(master(kind, rate_drop=8), axes=axes), np.random.default_rng(seed)

    def draw(scale):
        return value(tuple(rng.normal(0.0, scale, axes).tolist()))

    balance = 0.0
    for tick in range(60):
        if tick % 8 == 0:
            port.receive(draw(1.0))
        xd = draw(0.3)
        asked = port.step(xd, xd)
        applied = asked * rng.uniform(-1.0, 1.0) if tick % 3 else asked
        port.applied(applied)
        got = np.dot(port.v_m, port.v_m) / 2 + np.dot(applied, xd)
        balance += TICK_S * (got - np.dot(port.u_m, port.u_m) / 2)
        e = port.s
        assert balance + e.deficit_j >= -1e-12 * (1.0 + e.u_m_j)


@given(seeds)
def test_a_change_while_running_makes_no_energy_and_accounts_go_on(seed):
    """Another share, order, impedance or anti-aliasing filter at a frame start."""
    rng = np.random.default_rng(seed)
    port = Port(master(order=2, share=0.5))
    environment = AllPass(0.3, -1.0)
    last = 0.0
    for k in range(300):
        if k % 40 == 39:
            port.configure(
                master(
                    order=int(rng.integers(2, 4)),
                    share=float(rng.uniform(0.1, 0.7)),
                    impedance=float(rng.uniform(5.0, 60.0)),
                )
            )
            assert port.energies["velocity_filter"] == last
        port.receive(environment.step(port.send()))
        port.applied(port.step(0.0, float(rng.normal(0.0, 0.2))))
        last = port.energies["velocity_filter"]
        e = port.s
        assert e.u_m_j - e.v_m_j >= -1e-7 * e.u_m_j
