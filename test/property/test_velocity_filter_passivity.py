# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A velocity filter in the waves of a port returns no more energy than it received, whatever
passive thing is behind it; where a margin is missing, it returns more.
"""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from support.port_parts import AllPass, Echo, Part, Waves
from support.port_rig import Port
from support.strategies import TICK_S

from pmwvc_core.params import (
    FilterParams,
    MasterParams,
    VelocityFilterParams,
)
from pmwvc_core.wave.velocity_filter_design import chosen
from reproduction.branches import branches, margins

POLE_RAD_S = float(-np.log(0.95) / TICK_S)  # 0.05/(z - 0.95), App. D Eq. 15
seeds = st.integers(0, 2**32 - 1)


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
    ran = behind(params, AllPass(a, sign)).run(np.sin(w * np.arange(20_000)).tolist())
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
