# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy account of the implicit coupling, at every step and under any waves, behind numbers
and behind matrices that couple the axes; and each principal axis of a matrix by itself.

Turned sessions: ``unit/test_several_axes.py``; the master's port: ``test_master_passivity.py``.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import Users
from support.strategies import behind, matrices

from pmwvc_core.params import ContactParams, MasterParams, ServerParams
from pmwvc_core.wave.impedance import MatrixImpedance

stiffnesses = st.one_of(st.just(0.0), st.floats(1e-2, 1e6))
dampings = st.one_of(st.just(0.0), st.floats(1e-2, 200.0))
contact_params = st.builds(
    ContactParams,
    impedance=st.floats(1.0, 300.0),
    contact=st.sampled_from(["bilateral", "grip"]),
    contact_stiffness=stiffnesses,
    contact_damping=dampings,
    gap_m=st.sampled_from([0.0, 0.003]),
)
server_params = st.builds(
    ServerParams,
    coupling=st.just("implicit"),
    environment=st.sampled_from(["cube", "cube", "wall"]),
    period_s=st.sampled_from([0.001, 0.008, 0.05]),
    object_mass=st.floats(0.01, 50.0),
    object_damping=st.one_of(st.just(0.0), st.floats(0.01, 50.0)),
)


def power(wave):
    """Return |wave|^2/2, summed over the axes."""
    return 0.5 * np.dot(wave, wave)


def random_waves(rng, axes, *, size, memory):
    """Yield waves that forget with every step what ``memory`` leaves over."""
    wave = np.zeros(axes)
    while True:
        wave = memory * wave + np.sqrt(1.0 - memory**2) * size * rng.normal(size=axes)
        yield wave


def drive(server, rng, *, size, memory, steps):
    """Let all users join, feed random waves, yield both waves of all ports, and the energy and
    heat of every step.
    """
    users, axes = range(len(server.present)), server.axes
    for i in users:
        server.join(i, rng.normal(0.0, 0.05, axes))
    waves = [random_waves(rng, axes, size=size, memory=memory) for _ in users]
    for _ in range(steps):
        received = [next(wave) for wave in waves]
        stored, lost = server.stored, server.dissipated
        returned = server.step(received)
        yield received, returned, server.stored - stored, server.dissipated - lost


@settings(max_examples=20)
@given(
    params=server_params,
    contacts=st.lists(contact_params, min_size=1, max_size=6),
    dof=st.integers(1, 6),
    coupled=st.booleans(),
    data=st.data(),
    size=st.sampled_from([1e-3, 0.3, 3.0]),
    memory=st.sampled_from([0.0, 0.9, 0.99]),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_implicit_coupling_accounts_for_every_joule_at_every_step(
    params, contacts, dof, coupled, data, size, memory, seed
):
    """Of all, and at every port: force times velocity is the power of its waves; ``coupled`` has
    every other user behind a matrix.
    """
    masters, coupled = [MasterParams()] * len(contacts), coupled and dof > 1
    for i in range(0, len(contacts), 2) if coupled else ():
        masters[i] = behind(data.draw(matrices(dof)))
        contacts[i] = replace(contacts[i], impedance=None)
    server, rounding = Users(params, contacts, masters=masters, axes=dof), 1e-12
    if coupled:
        rounding = 1e-11
    through, rng = 0.0, np.random.default_rng(seed)
    for u, v, stored, lost in drive(server, rng, size=size, memory=memory, steps=50):
        came, went = sum(map(power, u)), sum(map(power, v))
        through += params.period_s * (came + went)
        assert abs(stored + lost - params.period_s * (came - went)) <= rounding * through
        assert lost >= -1e-13 * through, "contacts and ground only take energy"
        for here, back, f_s, xd_s in zip(u, v, server.f_s, server.xd_s, strict=True):
            both = power(here) + power(back)
            assert abs(power(here) - power(back) - np.dot(f_s, xd_s)) <= 1e-10 * both


@pytest.mark.parametrize("coupling", ["one_step_delay", "one_frame_late", "unwrapped"])
def test_the_other_couplings_do_not_balance_on_a_cube(coupling):
    """The control: an account that closes for any coupling would prove nothing."""
    rng = np.random.default_rng(8)
    contacts = [ContactParams(contact="bilateral")] * 2
    server = Users(ServerParams(coupling=coupling), contacts)
    worst = through = 0.0
    for u, v, stored, lost in drive(server, rng, size=0.3, memory=0.5, steps=200):
        came, went = sum(map(power, u)), sum(map(power, v))
        through += 0.008 * (came + went)
        worst = max(worst, abs(stored + lost - 0.008 * (came - went)) / through)
    assert worst > 1e-4


def played(impedances, starts, waves, coupling):
    """Return all signals of every step ``(steps, signals, dof)``."""
    touch = ContactParams(contact="bilateral", contact_stiffness=200.0, contact_damping=1.0)
    masters, axes = [behind(b) for b in impedances], np.size(starts[0])
    server = Users(ServerParams(coupling=coupling), [touch] * 2, masters=masters, axes=axes)
    for i, start in enumerate(starts):
        server.join(i, start)
    rows = []
    for received in waves:
        server.step(list(received))
        signals = [*server.x_s, *server.xd_s, *server.f_s, *server.v_s, server.x_o]
        rows.append([np.atleast_1d(each) for each in signals])
    return np.array(rows)


@pytest.mark.parametrize("coupling", ["implicit", "one_step_delay", "one_frame_late", "unwrapped"])
@settings(max_examples=8)
@given(dof=st.integers(2, 4), seed=st.integers(0, 2**32 - 1))
def test_along_its_principal_axes_a_matrix_is_one_number_per_axis(coupling, dof, seed):
    rng = np.random.default_rng(seed)
    values = np.sort(rng.uniform(5.0, 80.0, dof))
    starts, waves = rng.normal(0.0, 0.03, (2, dof)), rng.normal(0.0, 0.5, (30, 2, dof))
    rows = played([MatrixImpedance(values, np.eye(dof))] * 2, starts, waves, coupling)
    for axis, b in enumerate(values.tolist()):
        alone = starts[:, axis].tolist(), waves[:, :, axis].tolist(), coupling
        single = played([b] * 2, *alone)
        np.testing.assert_allclose(rows[..., axis], single[..., 0], rtol=1e-9, atol=1e-9)
        other = played([1.1 * b] * 2, *alone)
        assert np.abs(rows[..., axis] - other[..., 0]).max() > 1e-4  # the control
