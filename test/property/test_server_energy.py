# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy account of the implicit coupling, at every step and under any waves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmwvc_core.controllers.ends import make_server
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
    return 0.5 * np.sum(np.square(wave), axis=-1, keepdims=True)


def random_waves(rng, shape, *, size, memory):
    """Yield waves that forget with every step what ``memory`` leaves over."""
    wave = np.zeros(shape)
    while True:
        wave = memory * wave + np.sqrt(1.0 - memory**2) * size * rng.normal(size=shape)
        yield wave


def as_signal(array):
    """Return what a law runs on: a float where there is one axis and one run."""
    return float(array[0]) if array.shape == (1,) else array


def drive(server, rng, shape, *, size, memory, steps):
    """Let all users join, feed random waves, yield energy and motion of every step."""
    users = range(len(server.ports))
    for i in users:
        server.join(i, as_signal(rng.normal(0.0, 0.05, shape)))
    waves = [random_waves(rng, shape, size=size, memory=memory) for _ in users]
    for _ in range(steps):
        received = [next(wave) for wave in waves]
        before = np.asarray(server.kinetic + server.potential), np.asarray(server.dissipated)
        returned = server.step([as_signal(u) for u in received])
        after = np.asarray(server.kinetic + server.potential), np.asarray(server.dissipated)
        u = sum(power(wave) for wave in received)
        v = sum(power(np.broadcast_to(wave, shape)) for wave in returned)
        yield u, v, after[0] - before[0], after[1] - before[1]


@settings(max_examples=80)
@given(
    params=server_params,
    contacts=st.lists(contact_params, min_size=1, max_size=8),
    dof=st.integers(1, 3),
    runs=st.sampled_from([0, 0, 3]),
    size=st.sampled_from([1e-3, 0.3, 3.0]),
    memory=st.sampled_from([0.0, 0.9, 0.99]),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_implicit_coupling_accounts_for_every_joule_at_every_step(
    params, contacts, dof, runs, size, memory, seed
):
    rng = np.random.default_rng(seed)
    sides = [-1 if i % 2 == 0 else 1 for i in range(len(contacts))]
    server = make_server("pmwvc", params, contacts, [25.0] * len(contacts), dof=dof, sides=sides)
    shape = (runs, dof) if runs else (dof,)
    throughput = 0.0
    for u, v, stored, lost in drive(server, rng, shape, size=size, memory=memory, steps=60):
        throughput = throughput + params.period_s * (u + v)
        residual = stored + lost - params.period_s * (u - v)
        assert np.all(np.abs(residual) <= 1e-12 * throughput)
        assert np.all(lost >= -1e-15 * throughput), "contacts and ground only take energy"


@settings(max_examples=40)
@given(
    coupling=st.sampled_from(["implicit", "one_step_delay", "one_frame_late", "unwrapped"]),
    environment=st.sampled_from(["cube", "wall"]),
    integrator=st.sampled_from(["forward_euler", "backward_euler", "trapezoid"]),
    contact=st.sampled_from(["bilateral", "grip"]),
    dof=st.sampled_from([1, 3]),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_batch_is_the_same_as_its_runs_one_by_one(
    coupling, environment, integrator, contact, dof, seed
):
    rng = np.random.default_rng(seed)
    runs, users, steps = 2, 3, 25
    names = dict(coupling=coupling, environment=environment, integrator=integrator)
    k, b_c = rng.uniform(0.0, 900.0, (runs, 1)), rng.uniform(0.0, 9.0, (runs, 1))
    mass, ground = rng.uniform(0.5, 5.0, (runs, 1)), rng.uniform(0.0, 5.0, (runs, 1))
    b = rng.uniform(15.0, 60.0, (runs, 1))
    starts = rng.normal(0.0, 0.03, (users, runs, dof))
    waves = rng.normal(0.0, 0.5, (steps, users, runs, dof))

    def play(pick):
        server = make_server(
            "pmwvc",
            ServerParams(object_mass=pick(mass), object_damping=pick(ground), **names),
            [ContactParams(contact=contact, contact_stiffness=pick(k), contact_damping=pick(b_c))]
            * users,
            [pick(b)] * users,
            dof=dof,
            sides=[-1, 1, -1],
        )
        for i in range(users):
            server.join(i, pick(starts[i]))
        rows = []
        for n in range(steps):
            server.step([pick(waves[n, i]) for i in range(users)])
            state = [*server.x_s, *server.f_s, *server.v_s, server.x_o, server.xd_o]
            sums = [server.kinetic, server.potential, server.dissipated, *server.energy_v_s]
            rows.append((state, sums))
        return rows

    together = play(lambda value: value)
    for run in range(runs):
        alone = play(lambda value, run=run: single(value[run]))
        for (state, sums), (state_1, sums_1) in zip(together, alone, strict=True):
            for many, one in zip((*state, *sums), (*state_1, *sums_1), strict=True):
                # A wall's state is a plain zero in both.
                many = np.broadcast_to(many, (runs, np.size(one)))[run]
                np.testing.assert_allclose(many, np.ravel(one), rtol=1e-12, atol=1e-12)


def single(values):
    """Return one run's parameter or signal: a float for one number."""
    return float(values[0]) if values.size == 1 else values


@pytest.mark.parametrize("coupling", ["one_step_delay", "one_frame_late", "unwrapped"])
def test_the_other_couplings_do_not_balance_on_a_cube(coupling):
    """The control: an account that closes for any coupling would prove nothing."""
    rng = np.random.default_rng(8)
    contacts = [ContactParams(contact="bilateral")] * 2
    server = make_server(
        "pmwvc", ServerParams(coupling=coupling), contacts, [25.0] * 2, dof=1, sides=[-1, 1]
    )
    worst = throughput = 0.0
    for u, v, stored, lost in drive(server, rng, (1,), size=0.3, memory=0.5, steps=200):
        throughput = throughput + 0.008 * (u + v)
        worst = max(worst, np.max(np.abs(stored + lost - 0.008 * (u - v)) / throughput))
    assert worst > 1e-4


@settings(max_examples=25)
@given(
    stiffness=st.floats(0.0, 1e5),
    damping=dampings,
    mass=st.floats(0.01, 10.0),
    contact=st.sampled_from(["bilateral", "grip"]),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_wave_gets_more_out_of_the_implicit_server_than_was_put_in(
    stiffness, damping, mass, contact, seed
):
    rng = np.random.default_rng(seed)
    contacts = [
        ContactParams(contact=contact, contact_stiffness=stiffness, contact_damping=damping)
    ] * 2
    server = make_server(
        "pmwvc", ServerParams(object_mass=mass), contacts, [25.0] * 2, dof=1, sides=[-1, 1]
    )
    taken = given = 0.0
    for u, v, _, _ in drive(server, rng, (1,), size=1.0, memory=0.9, steps=150):
        taken, given = taken + 0.008 * (u - v), given + 0.008 * u
        assert taken >= -1e-13 * given
