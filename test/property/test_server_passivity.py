# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Passivity of one wave port at a wall, on both sides of its thresholds."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support.law_rigs import Users

from pmwvc_core.params import ContactParams, ServerParams


def port_account(params, contact, waves):
    """Return the port's energy balance [J] after each wave, one user at a wall."""
    server = Users(params, [contact], b=contact.impedance, sides=[-1])
    server.join(0, 0.0)
    taken = []
    for wave in waves:
        server.step([wave])
        taken.append(server.taken_j)
    return np.array(taken)


DELAYED_WALL = ServerParams(
    coupling="one_step_delay", integrator="backward_euler", environment="wall", period_s=0.008
)


@settings(max_examples=50)
@given(
    b=st.floats(5.0, 100.0),
    share=st.floats(0.0, 1.0),
    fill=st.floats(0.0, 1.0),
    seed=st.integers(0, 2**32 - 1),
)
@example(b=25.0, share=0.2, fill=1.0, seed=0)  # K = 625 N/m, B = 10 N s/m up to rounding
def test_one_step_delay_is_passive_up_to_k_h_plus_2_b_equal_to_the_impedance(b, share, fill, seed):
    contact = ContactParams(
        impedance=b,
        contact="bilateral",
        contact_stiffness=share * fill * b / DELAYED_WALL.period_s,
        contact_damping=(1.0 - share) * fill * b / 2.0,
    )
    rng = np.random.default_rng(seed)
    waves = rng.normal(size=200) * np.exp(rng.normal(size=200))
    account = port_account(DELAYED_WALL, contact, waves.tolist())
    assert account.min() >= -1e-12 * np.sum(waves**2)


@settings(max_examples=30)
@given(b=st.floats(5.0, 100.0), share=st.floats(0.0, 1.0), excess=st.floats(0.01, 0.5))
@example(b=25.0, share=0.2, excess=0.01)
def test_one_step_delay_makes_energy_beyond_that(b, share, excess):
    contact = ContactParams(
        impedance=b,
        contact="bilateral",
        contact_stiffness=share * (1.0 + excess) * b / DELAYED_WALL.period_s,
        contact_damping=(1.0 - share) * (1.0 + excess) * b / 2.0,
    )
    # The reflection is largest at half the step rate.
    waves = [(-1.0) ** n for n in range(1500)]
    account = port_account(DELAYED_WALL, contact, waves)
    assert account[-1] < account[750] < 0.0


@pytest.mark.parametrize("period", [3, 8, 40])
def test_with_a_trapezoidal_spring_one_step_delay_is_active_at_every_frequency(period):
    """|reflection| > 1 where |a|^2 (1 - cos w) > Re a with a = F/(b xd), imaginary here."""
    params = ServerParams(
        coupling="one_step_delay", integrator="trapezoid", environment="wall", period_s=0.008
    )
    contact = ContactParams(
        impedance=25.0, contact="bilateral", contact_stiffness=300.0, contact_damping=0.0
    )
    waves = np.cos(2 * np.pi / period * np.arange(200 * period))
    account = port_account(params, contact, waves.tolist())[period - 1 :: period]
    assert np.all(np.diff(account[100:]) < 0.0)


def unwrapped_wall(integrator):
    return ServerParams(coupling="unwrapped", integrator=integrator, environment="wall")


@settings(max_examples=50)
@given(
    integrator=st.sampled_from(["backward_euler", "trapezoid"]),
    k=st.floats(0.0, 1e5),
    damping=st.floats(0.0, 100.0),
    seed=st.integers(0, 2**32 - 1),
)
def test_unwrapped_is_passive_at_a_wall_of_any_stiffness(integrator, k, damping, seed):
    contact = ContactParams(
        impedance=25.0, contact="bilateral", contact_stiffness=k, contact_damping=damping
    )
    waves = np.random.default_rng(seed).normal(size=200)
    account = port_account(unwrapped_wall(integrator), contact, waves.tolist())
    assert account.min() >= -1e-12 * np.sum(waves**2)


def test_unwrapped_as_published_is_not():
    """The spring of App. C, Eq. 4 hears of a velocity a step late: Re F/xd = B - K h/2."""
    contact = ContactParams(
        impedance=25.0, contact="bilateral", contact_stiffness=3000.0, contact_damping=2.0
    )
    waves = [(-1.0) ** n for n in range(500)]
    account = port_account(unwrapped_wall("forward_euler"), contact, waves)
    assert account[-1] < account[250] < 0.0
