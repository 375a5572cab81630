# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Passivity of one wave port at a wall, on both sides of its thresholds."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support.law_rigs import Users

from pmwvc_core.params import ContactParams, ServerParams

H = 0.008
PASSIVE_AT_ANY_STIFFNESS = (
    ("unwrapped", "backward_euler"),
    ("unwrapped", "trapezoid"),
    ("implicit", "backward_euler"),
)
ALTERNATING = [(-1.0) ** n for n in range(800)]  # the reflection is largest at half the rate


def balances(scheme, k, damping, waves, b=25.0):
    """Return the port's energy balance [J] after each wave, one user at a wall."""
    coupling, integrator = scheme
    params = ServerParams(coupling=coupling, integrator=integrator, environment="wall", period_s=H)
    touch = ContactParams(contact="bilateral", contact_stiffness=k, contact_damping=damping)
    server = Users(params, [touch], b=b, sides=[-1])
    server.join(0, 0.0)
    return np.array([(server.step([wave]), server.taken_j)[1] for wave in waves])


def drawn(seed):
    rng = np.random.default_rng(seed)
    return rng.normal(size=200) * np.exp(rng.normal(size=200))


@settings(max_examples=20)
@given(
    b=st.floats(5.0, 100.0),
    share=st.floats(0.0, 1.0),
    fill=st.floats(0.0, 1.0),
    excess=st.floats(0.01, 0.5),
    seed=st.integers(0, 2**32 - 1),
)
@example(b=25.0, share=0.2, fill=1.0, excess=0.01, seed=0)  # K = 625 N/m, B = 10 up to rounding
def test_one_step_delay_is_passive_up_to_k_h_plus_2_b_equal_to_the_impedance_and_not_beyond(
    b, share, fill, excess, seed
):
    scheme, k, damping = ("one_step_delay", "backward_euler"), share * b / H, (1.0 - share) * b / 2
    waves = drawn(seed)
    within = balances(scheme, fill * k, fill * damping, waves.tolist(), b)
    assert within.min() >= -1e-12 * np.sum(waves**2)
    beyond = balances(scheme, (1.0 + excess) * k, (1.0 + excess) * damping, ALTERNATING, b)
    assert beyond[-1] < beyond[400] < 0.0


@pytest.mark.parametrize("period", [3, 8, 40])
def test_with_a_trapezoidal_spring_one_step_delay_is_active_at_every_frequency(period):
    """|reflection| > 1 where |a|^2 (1 - cos w) > Re a with a = F/(b xd), imaginary here."""
    waves = np.cos(2 * np.pi / period * np.arange(200 * period))
    found = balances(("one_step_delay", "trapezoid"), 300.0, 0.0, waves.tolist())
    assert np.all(np.diff(found[period - 1 :: period][100:]) < 0.0)


@settings(max_examples=20)
@given(
    st.sampled_from(PASSIVE_AT_ANY_STIFFNESS),
    st.floats(0.0, 1e5),
    st.floats(0.0, 100.0),
    st.integers(0, 2**32 - 1),
)
def test_solved_loops_are_passive_at_a_wall_of_any_stiffness(scheme, k, damping, seed):
    waves = drawn(seed)
    found = balances(scheme, k, damping, waves.tolist())
    assert found.min() >= -1e-12 * np.sum(waves**2)


def test_unwrapped_as_published_is_not():
    """The spring of App. C, Eq. 4 hears of a velocity a step late: Re F/xd = B - K h/2."""
    found = balances(("unwrapped", "forward_euler"), 3000.0, 2.0, ALTERNATING[:500])
    assert found[-1] < found[250] < 0.0
