# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contacts behind an impedance that couples the axes: answers satisfy law and port at once."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.strategies import matrices

from pmwvc_core.params import ContactParams
from pmwvc_core.server.factory import make_contact
from pmwvc_core.wave.impedance import MatrixImpedance

H = 0.008
contacts = st.builds(
    ContactParams,
    contact=st.sampled_from(["bilateral", "grip"]),
    contact_stiffness=st.floats(1.0, 5e3),
    contact_damping=st.floats(0.0, 50.0),
)
seeds = st.integers(0, 2**32 - 1)


def pressed(params, b, rng, *, side=1, coupled=True):
    """Return a contact that is anywhere near its face, and pulled sideways where it holds."""
    dof = len(b.values)
    contact = make_contact(params, side=side, size=0.06, dof=dof, coupled=coupled)
    contact.attach(np.array([side * 0.031, *np.zeros(dof - 1)]))
    contact.slide(np.array([-side * rng.uniform(0.0, 0.004), *np.zeros(dof - 1)]))
    contact.slide(np.array([0.0, *rng.normal(0.0, 0.002, dof - 1)]))
    return contact


def mean_normal(grip, rate):
    """Return the mean force of a one-sided contact over a step, from its potential."""
    p0 = grip.depth[0]
    p1 = p0 + H * grip.inward * rate
    inside = [max(p, 0.0) for p in (p0, p1)]
    spring = 0.5 * grip.stiffness * (inside[1] ** 2 - inside[0] ** 2) / (p1 - p0)
    return grip.inward * max(0.0, spring + grip.damping * (inside[1] - inside[0]) / H)


@settings(max_examples=80)
@given(params=contacts, b=matrices(), side=st.sampled_from([-1, 1]), seed=seeds)
def test_the_mean_force_satisfies_contact_and_port(params, b, side, seed):
    rng = np.random.default_rng(seed)
    contact = pressed(params, b, rng, side=side)
    free = rng.normal(0.0, 0.3, len(b.values))
    answer = contact.answer(free, b, H)
    scale = 1e-7 * (1.0 + np.abs(answer.force).max())
    np.testing.assert_allclose(answer.rate, free - answer.force / b, atol=1e-7)
    gain = 0.5 * H * params.contact_stiffness + params.contact_damping
    law = params.contact_stiffness * contact.deflection + gain * answer.rate
    if params.contact == "grip":
        law = np.where(contact.touching, law, 0.0)
        law[0] = mean_normal(contact.grip, answer.rate[0])
    np.testing.assert_allclose(answer.force, law, rtol=1e-6, atol=scale)


@settings(max_examples=80)
@given(params=contacts, b=matrices(), seed=seeds)
def test_the_slope_is_the_fall_of_the_force(params, b, seed):
    rng = np.random.default_rng(seed)
    contact = pressed(params, b, rng)
    dof = len(b.values)
    free = rng.normal(0.0, 0.05, dof)
    slope = contact.answer(free, b, H).slope
    np.testing.assert_allclose(slope, slope.T, atol=1e-9 * (1.0 + np.abs(slope).max()))
    assert np.linalg.eigvalsh(slope)[0] >= -1e-9 * np.abs(slope).max()
    step = 1e-6
    found = np.empty((dof, dof))
    kinks = False
    for axis in range(dof):
        sides = [contact.answer(free + s * step * np.eye(dof)[axis], b, H) for s in (-1, 0, 1)]
        falls = [(one.force - two.force) / step for two, one in itertools.pairwise(sides)]
        kinks = kinks or np.abs(falls[0] - falls[1]).max() > 1e-3 * (1.0 + np.abs(falls[0]).max())
        found[axis] = (sides[2].force - sides[0].force) / (2.0 * step)
    if not kinks:
        np.testing.assert_allclose(
            slope, found, rtol=1e-3, atol=1e-3 * (1.0 + np.abs(found).max())
        )


@settings(max_examples=80)
@given(params=contacts, b=matrices(), weight=st.sampled_from([H, 0.5 * H]), seed=seeds)
def test_an_unwrapped_force_fits_the_velocity_it_leaves(params, b, weight, seed):
    rng = np.random.default_rng(seed)
    contact = pressed(params, b, rng)
    held = np.all(contact.touching)
    free, xd_o = rng.normal(0.0, 0.05, (2, len(b.values)))
    force = contact.unwrapped(free, xd_o, b, weight)
    xd = free - force / b
    contact.slide(weight * xd)
    if held and np.all(contact.touching):
        expected = contact.force(xd - xd_o)
        if params.contact == "grip" and force[0] == 0.0:
            expected[0] = 0.0  # at the jump where the damper begins no force fits
        scale = 1e-7 * (1.0 + np.abs(expected).max())
        np.testing.assert_allclose(force, expected, rtol=1e-6, atol=scale)


@pytest.mark.parametrize("contact", ["bilateral", "grip"])
def test_the_plain_zero_of_a_first_packet_is_a_wave_of_zero(contact):
    b = MatrixImpedance(np.array([10.0, 20.0, 30.0]), np.eye(3))
    laws = [pressed(ContactParams(contact=contact), b, np.random.default_rng(4)) for _ in (0, 1)]
    xd_o = np.array([0.1, 0.0, -0.1])
    plain, whole = laws[0].unwrapped(0.0, xd_o, b, H), laws[1].unwrapped(0.0 * xd_o, xd_o, b, H)
    np.testing.assert_array_equal(plain, whole)


def test_a_grip_that_is_not_held_still_leans_sideways_on_the_port():
    """Pushed along axis 0 through a matrix, the avatar gives way across, too."""
    b = MatrixImpedance(*np.linalg.eigh(np.array([[30.0, 12.0], [12.0, 20.0]])))
    contact = make_contact(ContactParams(), side=1, size=0.06, dof=2, coupled=True)
    contact.attach(np.array([0.03, 0.0]))
    answer = contact.answer(np.array([-0.2, 0.0]), b, H)
    assert answer.force[0] < 0.0
    assert answer.force[1] == 0.0
    assert answer.rate[1] == pytest.approx((-answer.force / b)[1])
    assert abs(answer.rate[1]) > 1e-3
