# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server behind impedances that couple the axes: energy, and each principal axis by itself.

Turned sessions: ``unit/test_several_axes.py``; the master's port: ``test_master_passivity.py``.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import Users
from support.strategies import behind, matrices

from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.wave.impedance import MatrixImpedance

COUPLINGS = ("implicit", "one_step_delay", "one_frame_late", "unwrapped")
contacts = st.sampled_from(["bilateral", "grip"])
seeds = st.integers(0, 2**32 - 1)


def power(wave):
    return 0.5 * np.dot(wave, wave)


def make(impedances, *, dof, contact="grip", coupling="implicit", k=600.0, damping=8.0, **server):
    touch = ContactParams(contact=contact, contact_stiffness=k, contact_damping=damping)
    params, users = ServerParams(coupling=coupling, **server), len(impedances)
    return Users(params, [touch] * users, masters=[behind(b) for b in impedances], axes=dof)


def play(server, starts, waves):
    """Let all users join, return all signals of every step ``(steps, signals, dof)``."""
    for i, start in enumerate(starts):
        server.join(i, start)
    rows = []
    for received in waves:
        server.step(list(received))
        signals = [*server.x_s, *server.xd_s, *server.f_s, *server.v_s, server.x_o]
        rows.append([np.atleast_1d(each) for each in signals])
    return np.array(rows)


@settings(max_examples=25)
@given(
    dof=st.integers(2, 6),
    data=st.data(),
    contact=contacts,
    environment=st.sampled_from(["cube", "wall"]),
    k=st.sampled_from([0.0, 50.0, 5e3, 1e6]),
    damping=st.sampled_from([0.0, 8.0, 200.0]),
    mass=st.floats(0.01, 20.0),
    size=st.sampled_from([0.03, 1.0]),
    seed=seeds,
)
def test_the_implicit_coupling_accounts_for_every_joule_whatever_the_matrices(
    dof, data, contact, environment, k, damping, mass, size, seed
):
    """Of all, and at every port: force times velocity is the power of its waves."""
    rng = np.random.default_rng(seed)
    impedances = [data.draw(matrices(dof)), 25.0, data.draw(matrices(dof))]
    names = {"contact": contact, "k": k, "damping": damping, "environment": environment}
    server = make(impedances, dof=dof, object_mass=mass, **names)
    for i in range(3):
        server.join(i, rng.normal(0.0, 0.03, dof))
    through, wave = 0.0, [np.zeros(dof)] * 3
    for _ in range(50):
        wave = [0.9 * w + size * 0.44 * rng.normal(size=w.shape) for w in wave]
        lost, before = server.dissipated, server.stored + server.dissipated
        returned = server.step(wave)
        u, v = sum(map(power, wave)), sum(map(power, returned))
        through += 0.008 * (u + v)
        gain = server.stored + server.dissipated - before
        assert abs(gain - 0.008 * (u - v)) <= 1e-11 * through
        assert server.dissipated - lost >= -1e-13 * through
        for u, v, f_s, xd_s in zip(wave, returned, server.f_s, server.xd_s, strict=True):
            assert abs(power(u) - power(v) - f_s @ xd_s) <= 1e-10 * (power(u) + power(v))


@pytest.mark.parametrize("coupling", COUPLINGS)
@settings(max_examples=10)
@given(dof=st.integers(2, 4), seed=seeds)
def test_along_its_principal_axes_a_matrix_is_one_number_per_axis(coupling, dof, seed):
    rng = np.random.default_rng(seed)
    values = np.sort(rng.uniform(5.0, 80.0, dof))
    starts, waves = rng.normal(0.0, 0.03, (2, dof)), rng.normal(0.0, 0.5, (30, 2, dof))
    names = dict(contact="bilateral", coupling=coupling, k=200.0, damping=1.0)
    rows = play(make([MatrixImpedance(values, np.eye(dof))] * 2, dof=dof, **names), starts, waves)
    for axis, b in enumerate(values):
        alone = make([float(b)] * 2, dof=1, **names)
        single = play(alone, starts[:, axis].tolist(), waves[:, :, axis].tolist())
        np.testing.assert_allclose(rows[..., axis], single[..., 0], rtol=1e-9, atol=1e-9)
        other = play(make([1.1 * b] * 2, dof=1, **names), starts[:, axis], waves[:, :, axis])
        assert np.abs(rows[..., axis] - other[..., 0]).max() > 1e-4  # the control
