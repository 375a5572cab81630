# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What stands in the waves of a port, a filter bank or a velocity filter, returns no more energy
than it received, whatever passive thing is behind it; where a margin is missing, it returns more.
"""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.filter_runs import BUTTERWORTH, Stage
from support.law_rigs import Port
from support.port_parts import Part
from support.strategies import TICK_S, signals

from pmwvc_core.params import (
    BankParams,
    FilterParams,
    LocalModelParams,
    MasterParams,
    VelocityFilterParams,
)
from pmwvc_core.wave.velocity_filter_design import chosen
from reproduction.branches import branches, margins

POLE_RAD_S = float(-np.log(0.95) / TICK_S)  # 0.05/(z - 0.95), App. D Eq. 15
LOW_REACHING = {
    "high_pass_hz": 4.0,
    "high_pass_db": 3.0,
    "high_stop_hz": 0.4,
    "high_stop_db": 20.0,
}
STILL = (0.0,)  # places of the device
seeds = st.integers(0, 2**32 - 1)
reflections = st.one_of(st.sampled_from([-1.0, 1.0]), st.floats(-1.0, 1.0))


class Echo:
    """A delay of ``delay`` >= 1 ticks and reflections that change: passive."""

    def __init__(self, delay, reflections):
        self._line, self._reflections = [0.0] * delay, itertools.cycle(reflections)

    def step(self, u):
        self._line = [*self._line[1:], u]
        return next(self._reflections) * self._line[0]


class AllPass:
    """R = size (a + 1/z)/(1 + a/z), size <= 1: a passive environment of any phase."""

    def __init__(self, a, size):
        self._a, self._size, self._state = a, size, 0.0

    def step(self, u):
        y = self._a * u + self._state
        self._state = u - self._a * y
        return self._size * y


class Waves:
    """A part, an anti-aliasing filter and an environment that answers a tick later; any wave may
    go out. ``kept`` is the energy that stayed so far, in (wave)^2.
    """

    def __init__(self, params, environment, filtering=None, axes=1):
        self.part, self.environment = Part(params, axes=axes), environment
        self.filter = Stage(filtering, rate_drop=1) if filtering else None
        self.returned = self.kept = self.out = self.least = 0.0

    def step(self, u, x=0.0):
        """Send a wave with the device at x."""
        v = self.part.down(self.returned + 0.0 * u)
        v = v + self.part.offer(x)(u)
        on = self.part.step(u)
        self.returned = self.environment.step(self.filter.step(on) if self.filter else on)
        self.out += np.dot(u, u)
        self.kept += np.dot(u, u) - np.dot(v, v)
        self.least = min(self.least, self.kept)

    def run(self, waves, places=STILL):
        for u, x in zip(waves, itertools.cycle(places), strict=False):
            self.step(u, x)
        return self


def bank(matrix="", stiffness=0.0, damping=0.0, acts="everywhere", **values):
    return MasterParams(
        impedance_matrix=matrix,
        bank=BankParams(**values),
        local_model=LocalModelParams(stiffness=stiffness, damping=damping, acts=acts),
    )


@given(
    waves=signals(longest=120),
    pole=st.floats(0.1, 2000.0),
    stiffness=st.floats(0.0, 1e6),
    damping=st.one_of(st.just(0.0), st.floats(0.0, 1e4)),
    delay=st.integers(1, 30),
    reflections=st.lists(reflections, min_size=1, max_size=20),
    touching=st.lists(st.booleans(), min_size=1, max_size=7),
)
def test_the_complementary_bank_gives_out_no_more_than_it_got_at_any_tick(
    waves, pole, stiffness, damping, delay, reflections, touching
):
    """Whatever passive server and local model: here both change as they like."""
    params = bank("", stiffness, damping, "above", kind="complementary", split_rad_s=pole)
    places = [1.0 if there else -1.0 for there in touching]
    found = Waves(params, Echo(delay, reflections)).run(waves.tolist(), places)
    assert found.least >= -1e-9 * found.out


@pytest.mark.parametrize("matrix", ["", "30 2 0; 2 20 1; 0 1 25"])
@given(waves=signals(longest=60, dof=3), pole=st.floats(0.1, 2000.0), k=st.floats(0.0, 1e6))
def test_the_local_model_stores_and_turns_to_heat_what_its_port_gets(matrix, waves, pole, k):
    params = bank(matrix, k, 2.0, kind="complementary", split_rad_s=pole)
    found = Waves(params, Echo(1, [1.0]), axes=3).run(waves).part.energies
    taken = found["bank_high_in"] - found["bank_high_out"]
    kept = found["local_stored"] + found["local_dissipated"]
    assert abs(taken - kept) <= 1e-9 * (found["bank_high_in"] + 1e-12)
    assert found["local_stored"] >= 0.0


def most_given(params, waves, delays=(1,), signs=(1.0,), places=(STILL,)):
    """Return the most that the dissertation's arrangement gives out, over what went in."""
    found = []
    for delay, sign, at in itertools.product(delays, signs, places):
        one = Waves(params, Echo(delay, [sign]), BUTTERWORTH).run(waves, at)
        found.append(-one.least / one.out)
    return max(found)


def test_control_a_dissertation_bank_that_reaches_down_gives_out_more_than_it_got():
    """|LP1| + |LP2| |HP| is 1.90 at 9.4 Hz: a delay that turns the server's answer into the phase
    of the local model's finds it. With the same environment the complementary pair is passive.
    """
    waves = np.sin(2.0 * np.pi * 9.4e-3 * np.arange(2000)).tolist()
    around = {"delays": range(1, 60, 12), "signs": (-1.0, 1.0), "places": (STILL,)}
    assert most_given(bank(kind="dissertation", **LOW_REACHING), waves, **around) > 2.0
    params = bank(kind="complementary", split_rad_s=25.0)
    assert most_given(params, waves, **around) <= 1e-9


def test_control_a_local_model_that_opens_and_closes_makes_table_1_active():
    """With the filters of Table 1 |LP1| + |LP2| |HP| stays within 1e-12 of 1, so no linear
    environment makes the bank active by more. A contact that opens and closes at the frequency of
    the wave turns it into a steady one, in phase with the server's.
    """
    waves = (0.7 + np.cos(2.0 * np.pi * 0.2 * np.arange(1500))).tolist()
    around = [1.0, 1.0, -1.0, -1.0, -1.0]
    places = [sign * np.roll(around, shift) for shift in range(5) for sign in (-1.0, 1.0)]
    local = {"damping": 1e4, "acts": "above"}
    assert most_given(bank(kind="dissertation", **local), waves, places=places) > 0.2
    params = bank(kind="complementary", split_rad_s=100.0, **local)
    assert most_given(params, waves, places=places) <= 1e-9


def filtered(kind="exact", *, pole=POLE_RAD_S, impedance=30.0, **numbers):
    return MasterParams(
        impedance=impedance,
        rate_drop=1,
        hold="zoh",
        filter=FilterParams(kind="first_order", pole_rad_s=pole),
        velocity_filter=VelocityFilterParams(kind=kind, **numbers),
    )


def behind(params, environment):
    return Waves(params, environment, params.filter)


SHAPES = {
    "white": lambda rng, waves: waves,
    "slow": lambda rng, waves: np.cumsum(waves, axis=0),
    "sparse": lambda rng, waves: np.where(rng.random(len(waves)) < 0.03, 100.0 * waves.T, 0.0).T,
    "alternating": lambda rng, waves: (
        np.abs(waves) * np.stack([np.ones(len(waves)), (-1.0) ** np.arange(len(waves))], axis=1)
    ),
}


@given(
    st.builds(
        lambda pole, order, share: filtered(pole=pole, order=order, share=share),
        st.floats(5.0, 100.0),
        st.integers(2, 4),
        st.floats(0.05, 0.75),
    ),
    st.floats(-0.99, 0.99),
    st.floats(-1.0, 1.0),
    seeds,
    st.sampled_from(["white", "slow", "sparse"]),
)
def test_with_the_margin_no_environment_makes_a_velocity_filter_active(
    params, a, size, seed, shape
):
    rng = np.random.default_rng(seed)
    found = behind(params, AllPass(a, size))
    found.run(SHAPES[shape](rng, rng.standard_normal(300)).tolist())
    assert found.least >= -1e-7 * found.out


def test_control_the_printed_filter_is_active():
    """An all-pass of the phase that its branches need: as much as its margin says."""
    params = filtered(order=1, alpha=0.929)
    frequency = np.geomspace(0.05, 500.0, 4000)
    low, high = branches(chosen(params), frequency)
    found = margins(low, high, frequency, share=params.velocity_filter.share)
    place = int(np.argmax(found["any_environment"]))
    w = 2.0 * math.pi * frequency[place] * TICK_S  # the environment answers a tick later
    back = np.exp(1j * (np.angle(high[place] / low[place]) + w))
    z = np.exp(-1j * w)
    found_a = [
        (abs(sign * (a + z) / (1.0 + a * z) - back), a, sign)
        for a in np.linspace(-0.999, 0.999, 20001)
        for sign in (-1.0, 1.0)
    ]
    _, a, sign = min(found_a)
    ran = behind(params, AllPass(a, sign)).run(np.sin(w * np.arange(60_000)).tolist())
    stays = 1.0 - (1.0 - found["any_environment_margin"]) ** 2
    assert stays < -0.01
    assert ran.kept < 0.6 * stays * ran.out  # what is stored counts against it


def test_control_an_environment_that_shifts_frequencies_defeats_the_margin_for_any_phase():
    """It turns its sign at every tick: what is slow comes back fast."""
    beside = (-1.0) ** np.arange(3000)
    found = [
        behind(filtered(order=2, share=0.7), Echo(1, [-1.0, 1.0])).run((1.0 + each).tolist())
        for each in (0.5 * beside, -0.5 * beside)
    ]
    assert min(one.kept / one.out for one in found) < -0.3


@given(
    order=st.integers(1, 3),
    share=st.floats(0.1, 1.0),
    cutoff_hz=st.floats(2.0, 200.0),
    seed=seeds,
    shape=st.sampled_from(["white", "slow", "alternating"]),
)
def test_the_complementary_velocity_filter_is_passive_by_itself(
    order, share, cutoff_hz, seed, shape
):
    """Whatever goes in at either end, at every tick: kept energy >= 0."""
    part = Part(filtered("complementary", order=order, share=share, cutoff_hz=cutoff_hz))
    rng = np.random.default_rng(seed)
    waves = SHAPES[shape](rng, rng.standard_normal((200, 2)))
    for u, w in waves.tolist():
        part.down(w)
        part.offer()
        part.step(u)
        assert part.energies["velocity_filter"] >= -1e-9 * TICK_S * np.sum(waves**2)


@settings(max_examples=20)  # each of 300 ticks
@given(seeds)
def test_a_change_while_running_makes_no_energy_and_accounts_go_on(seed):
    """Another share, order or impedance at a frame start."""
    rng = np.random.default_rng(seed)
    port, environment, last = Port(filtered(order=2, share=0.5)), AllPass(0.3, -1.0), 0.0
    for k in range(300):
        if k % 40 == 39:
            order, share = int(rng.integers(2, 4)), float(rng.uniform(0.1, 0.7))
            port.configure(filtered(order=order, share=share, impedance=rng.uniform(5.0, 60.0)))
            assert port.energies["velocity_filter"] == last
        port.receive(environment.step(port.send()))
        port.applied(port.step(0.0, float(rng.normal(0.0, 0.2))))
        last = port.energies["velocity_filter"]
        assert port.s.u_m_j - port.s.v_m_j >= -1e-7 * port.s.u_m_j
