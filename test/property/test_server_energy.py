# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy account of the implicit coupling, at every step and under any waves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import Users

from pmwvc_core.params import ContactParams, ServerParams

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
    """Let all users join, feed random waves, yield energy and motion of every step."""
    users, axes = range(len(server.present)), server.axes
    for i in users:
        server.join(i, rng.normal(0.0, 0.05, axes))
    waves = [random_waves(rng, axes, size=size, memory=memory) for _ in users]
    for _ in range(steps):
        received = [next(wave) for wave in waves]
        stored, lost = server.stored, server.dissipated
        returned = server.step(received)
        u, v = sum(map(power, received)), sum(map(power, returned))
        yield u, v, server.stored - stored, server.dissipated - lost


@settings(max_examples=40)
@given(
    params=server_params,
    contacts=st.lists(contact_params, min_size=1, max_size=8),
    dof=st.integers(1, 3),
    size=st.sampled_from([1e-3, 0.3, 3.0]),
    memory=st.sampled_from([0.0, 0.9, 0.99]),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_implicit_coupling_accounts_for_every_joule_at_every_step(
    params, contacts, dof, size, memory, seed
):
    rng = np.random.default_rng(seed)
    server = Users(params, contacts, axes=dof)
    throughput = 0.0
    for u, v, stored, lost in drive(server, rng, size=size, memory=memory, steps=60):
        throughput += params.period_s * (u + v)
        residual = stored + lost - params.period_s * (u - v)
        assert abs(residual) <= 1e-12 * throughput
        assert lost >= -1e-15 * throughput, "contacts and ground only take energy"


@pytest.mark.parametrize("coupling", ["one_step_delay", "one_frame_late", "unwrapped"])
def test_the_other_couplings_do_not_balance_on_a_cube(coupling):
    """The control: an account that closes for any coupling would prove nothing."""
    rng = np.random.default_rng(8)
    contacts = [ContactParams(contact="bilateral")] * 2
    server = Users(ServerParams(coupling=coupling), contacts)
    worst = throughput = 0.0
    for u, v, stored, lost in drive(server, rng, size=0.3, memory=0.5, steps=200):
        throughput += 0.008 * (u + v)
        worst = max(worst, abs(stored + lost - 0.008 * (u - v)) / throughput)
    assert worst > 1e-4
