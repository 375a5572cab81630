# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contacts behind an impedance that couples the axes: answers satisfy law and port at once."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from support.strategies import matrices

from pmwvc_core.law.server.contacts import attached, contact_force, slid, touching
from pmwvc_core.law.server.coupled_axes import coupled_answer
from pmwvc_core.law.server.coupling import solved_contact
from pmwvc_core.law.server.springs import depth
from pmwvc_core.made.server import contact_of
from pmwvc_core.made.waves import made_impedance
from pmwvc_core.params import ContactParams

H = 0.008
contacts = st.builds(
    ContactParams,
    contact=st.sampled_from(["bilateral", "grip"]),
    contact_stiffness=st.floats(1.0, 5e3),
    contact_damping=st.floats(0.0, 50.0),
)
seeds = st.integers(0, 2**32 - 1)


def pressed(params, b, rng, *, side=1):
    """Return a contact that is anywhere near its face, and pulled sideways where it holds."""
    dof = len(b.values)
    contact = contact_of(params, side=side, size=0.06, axes=dof)
    contact = attached(contact, (side * 0.031, *(0.0,) * (dof - 1)))
    contact, _ = slid(contact, (-side * rng.uniform(0.0, 0.004), *(0.0,) * (dof - 1)))
    contact, _ = slid(contact, (0.0, *rng.normal(0.0, 0.002, dof - 1).tolist()))
    return contact


def answer_of(contact, free, b):
    """Return force, rate and slope as arrays."""
    answer = coupled_answer(contact, tuple(free.tolist()), made_impedance(b), H)
    return tuple(np.array(part) for part in answer)


def mean_normal(contact, rate):
    """Return the mean force of a one-sided contact over a step, from its potential."""
    law = contact.law
    p0 = depth(contact.springs[0], law)
    p1 = p0 + H * law.inward * rate
    inside = [max(p, 0.0) for p in (p0, p1)]
    spring = 0.5 * law.stiffness * (inside[1] ** 2 - inside[0] ** 2) / (p1 - p0)
    return law.inward * max(0.0, spring + law.damping * (inside[1] - inside[0]) / H)


@settings(max_examples=80)
@given(params=contacts, b=matrices(), side=st.sampled_from([-1, 1]), seed=seeds)
def test_the_mean_force_satisfies_contact_and_port(params, b, side, seed):
    rng = np.random.default_rng(seed)
    contact = pressed(params, b, rng, side=side)
    free = rng.normal(0.0, 0.3, len(b.values))
    force, rate, _ = answer_of(contact, free, b)
    scale = 1e-7 * (1.0 + np.abs(force).max())
    np.testing.assert_allclose(rate, free - force / b, atol=1e-7)
    gain = 0.5 * H * params.contact_stiffness + params.contact_damping
    deflection = np.array([spring.deflection for spring in contact.springs])
    law = params.contact_stiffness * deflection + gain * rate
    if params.contact == "grip":
        law = np.where(touching(contact), law, 0.0)
        law[0] = mean_normal(contact, rate[0])
    np.testing.assert_allclose(force, law, rtol=1e-6, atol=scale)


@settings(max_examples=80)
@given(params=contacts, b=matrices(), weight=st.sampled_from([H, 0.5 * H]), seed=seeds)
def test_an_unwrapped_force_fits_the_velocity_it_leaves(params, b, weight, seed):
    rng = np.random.default_rng(seed)
    contact = pressed(params, b, rng)
    held = touching(contact)
    free, xd_o = rng.normal(0.0, 0.05, (2, len(b.values)))
    signals = tuple(free.tolist()), tuple(xd_o.tolist())
    force = np.array(solved_contact(made_impedance(b), contact, *signals, weight))
    xd = free - force / b
    contact, _ = slid(contact, tuple((weight * xd).tolist()))
    if held and touching(contact):
        expected = np.array(contact_force(contact, tuple((xd - xd_o).tolist())))
        if params.contact == "grip" and force[0] == 0.0:
            expected[0] = 0.0  # at the jump where the damper begins no force fits
        scale = 1e-7 * (1.0 + np.abs(expected).max())
        np.testing.assert_allclose(force, expected, rtol=1e-6, atol=scale)
