# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Ports whose impedance couples the axes: energy, passivity, and what may not depend on axes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import Port, Users
from support.strategies import matrices

from pmwvc_core.numeric import root
from pmwvc_core.params import ContactParams, FilterParams, MasterParams, ServerParams
from pmwvc_core.wave.impedance import MatrixImpedance

COUPLINGS = ("implicit", "one_step_delay", "one_frame_late", "unwrapped")
seeds = st.integers(0, 2**32 - 1)


def text_of(matrix):
    return "; ".join(" ".join(repr(float(entry)) for entry in row) for row in matrix)


def power(wave):
    return 0.5 * np.dot(wave, wave)


def behind(b, **names):
    """Return the parameters of a master behind a number or a matrix."""
    if isinstance(b, MatrixImpedance):
        return MasterParams(impedance_matrix=text_of(b.matrix), **names)
    return MasterParams(impedance=b, **names)


def make(impedances, *, dof, contact="grip", coupling="implicit", k=600.0, damping=8.0, **server):
    contacts = [
        ContactParams(contact=contact, contact_stiffness=k, contact_damping=damping)
    ] * len(impedances)
    params = ServerParams(coupling=coupling, **server)
    return Users(params, contacts, masters=[behind(b) for b in impedances], axes=dof)


def play(server, starts, waves):
    """Let all users join, return all signals of every step."""
    for i, start in enumerate(starts):
        server.join(i, start)
    rows = []
    for received in waves:
        server.step(list(received))
        rows.append([*server.x_s, *server.xd_s, *server.f_s, *server.v_s, server.x_o])
    return rows


@settings(max_examples=60)
@given(
    dof=st.integers(2, 6),
    data=st.data(),
    contact=st.sampled_from(["bilateral", "grip"]),
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
    rng = np.random.default_rng(seed)
    impedances = [data.draw(matrices(dof)), 25.0, data.draw(matrices(dof))]
    server = make(
        impedances, dof=dof, contact=contact, k=k, damping=damping, environment=environment,
        object_mass=mass,
    )  # fmt: skip
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


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("contact", ["bilateral", "grip"])
@settings(max_examples=10)
@given(dof=st.integers(2, 6), seed=seeds)
def test_a_multiple_of_the_identity_is_the_number(coupling, contact, dof, seed):
    rng = np.random.default_rng(seed)
    b = float(rng.uniform(5.0, 60.0))
    axes, _ = np.linalg.qr(rng.normal(size=(dof, dof)))
    matrix = MatrixImpedance(np.full(dof, b), axes)
    starts = rng.normal(0.0, 0.03, (3, dof))
    waves = rng.normal(0.0, 0.5, (40, 3, dof))
    names = dict(dof=dof, contact=contact, coupling=coupling)
    number = play(make([b] * 3, **names), starts, waves)
    same = play(make([matrix, b, matrix], **names), starts, waves)
    for row, other in zip(number, same, strict=True):
        for one, two in zip(row, other, strict=True):
            np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("coupling", COUPLINGS)
@settings(max_examples=10)
@given(dof=st.integers(2, 6), data=st.data(), seed=seeds)
def test_turning_motion_and_matrices_together_turns_everything(coupling, dof, data, seed):
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(dof, dof)))
    straight = [data.draw(matrices(dof)) for _ in range(2)]
    turned = [MatrixImpedance(b.values, turn @ b.axes) for b in straight]
    starts = rng.normal(0.0, 0.03, (2, dof))
    waves = rng.normal(0.0, 0.5, (30, 2, dof))
    names = dict(dof=dof, contact="bilateral", coupling=coupling, k=60.0, damping=0.2)
    before = play(make(straight, **names), starts, waves)
    after = play(make(turned, **names), starts @ turn.T, waves @ turn.T)
    for row, other in zip(before, after, strict=True):
        for one, two in zip(row, other, strict=True):
            scale = 1e-9 * (1.0 + np.abs(one).max())
            np.testing.assert_allclose(one @ turn.T, two, atol=scale)


def test_turning_the_matrix_alone_turns_nothing():
    """The control: with a matrix that is no multiple of the identity, its axes matter."""
    b, wave = MatrixImpedance(np.array([5.0, 60.0]), np.eye(2)), np.array([1.0, 0.5])
    quarter = MatrixImpedance(b.values, np.array([[0.0, -1.0], [1.0, 0.0]]))
    names = dict(dof=2, contact="bilateral")
    rows = [play(make([m], **names), [np.zeros(2)], [[wave]] * 5) for m in (b, quarter)]
    assert np.abs(rows[0][-1][0] - rows[1][-1][0]).max() > 1e-4


@pytest.mark.parametrize("coupling", COUPLINGS)
@settings(max_examples=10)
@given(dof=st.integers(2, 6), seed=seeds)
def test_along_its_principal_axes_a_matrix_is_one_number_per_axis(coupling, dof, seed):
    rng = np.random.default_rng(seed)
    values = np.sort(rng.uniform(5.0, 80.0, dof))
    starts = rng.normal(0.0, 0.03, (2, dof))
    waves = rng.normal(0.0, 0.5, (30, 2, dof))
    names = dict(contact="bilateral", coupling=coupling, k=200.0, damping=1.0)
    together = make([MatrixImpedance(values, np.eye(dof))] * 2, dof=dof, **names)
    rows = play(together, starts, waves)
    for axis in range(dof):
        alone = make([float(values[axis])] * 2, dof=1, **names)
        single = play(alone, starts[:, axis].tolist(), waves[:, :, axis].tolist())
        for row, other in zip(rows, single, strict=True):
            for one, two in zip(row, other, strict=True):
                np.testing.assert_allclose(one[axis], two, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("coupling", ["implicit", "unwrapped"])
@settings(max_examples=15)
@given(
    dof=st.integers(2, 6),
    data=st.data(),
    contact=st.sampled_from(["bilateral", "grip"]),
    seed=seeds,
)
def test_force_and_velocity_fit_each_other_at_every_port(coupling, dof, data, contact, seed):
    rng = np.random.default_rng(seed)
    b = data.draw(matrices(dof))
    server = make([b, b], dof=dof, contact=contact, coupling=coupling)
    for i in (0, 1):
        server.join(i, rng.normal(0.0, 0.03, dof))
    for _ in range(30):
        waves = [rng.normal(0.0, 0.5, dof) for _ in (0, 1)]
        server.step(waves)
        for u, v, f_s, xd_s in zip(waves, server.v_s, server.f_s, server.xd_s, strict=True):
            scale = 1e-10 * (power(u) + power(v))
            assert abs(power(u) - power(v) - f_s @ xd_s) <= scale


class Account:
    """The energy account of a master's port, from its signals alone."""

    def __init__(self, b, **names):
        self.port = Port(behind(b, **names), axes=len(b.values))
        self.balance = 0.0

    def tick(self, xd, change):
        asked = self.port.step(xd, xd)
        applied = change(asked)
        self.port.applied(applied)
        got = power(self.port.v_m) + np.dot(applied, xd)
        self.balance += 0.001 * (got - power(self.port.u_m))
        return asked

    @property
    def tolerance(self):
        s = self.port.s
        return 1e-10 * (1.0 + s.v_m_j + s.u_m_j)


@settings(max_examples=40)
@given(b=matrices(), force=st.floats(0.01, 30.0), seed=seeds)
def test_any_force_at_all_is_paid_for_at_the_master(b, force, seed):
    rng, dof = np.random.default_rng(seed), len(b.values)
    account = Account(b, filter=FilterParams(kind="none"))
    for tick in range(80):
        if tick % 8 == 0:
            account.port.receive(rng.normal(0.0, 1.0, dof))
        account.tick(rng.normal(0.0, 0.3, dof), lambda asked: rng.normal(0.0, force, dof))
        assert account.balance + account.port.s.deficit_j >= -account.tolerance


@settings(max_examples=20)
@given(b=matrices(), seed=seeds)
def test_the_master_balances_exactly_where_nothing_is_limited(b, seed):
    rng, dof = np.random.default_rng(seed), len(b.values)
    account = Account(b, filter=FilterParams(kind="none"))
    for tick in range(40):
        if tick % 8 == 0:
            account.port.receive(rng.normal(0.0, 1.0, dof))
        account.tick(rng.normal(0.0, 0.3, dof), lambda asked: asked)
        assert abs(account.balance) <= account.tolerance


@settings(max_examples=20)
@given(b=matrices(), seed=seeds)
def test_turning_motion_and_matrix_together_turns_the_masters_force(b, seed):
    rng, dof = np.random.default_rng(seed), len(b.values)
    turn, _ = np.linalg.qr(rng.normal(size=(dof, dof)))
    turned = MatrixImpedance(b.values, turn @ b.axes)
    straight, other = Account(b), Account(turned)
    for tick in range(40):
        wave, xd = rng.normal(0.0, 1.0, dof), rng.normal(0.0, 0.3, dof)
        if tick % 8 == 0:
            straight.port.receive(wave)
            other.port.receive(turn @ wave)
        one = straight.tick(xd, lambda asked: 0.5 * asked)
        two = other.tick(turn @ xd, lambda asked: 0.5 * asked)
        np.testing.assert_allclose(turn @ one, two, atol=1e-7 * (1.0 + np.abs(one).max()))
        np.testing.assert_allclose(turn @ straight.port.send(), other.port.send(), atol=1e-6)


def test_a_matrix_may_stand_at_one_end_and_a_number_at_the_other():
    """At rest under a held force the two ends agree on it up to the transformer's ratio."""
    b = MatrixImpedance(*np.linalg.eigh(np.array([[30.0, 8.0], [8.0, 20.0]])))
    f_s = np.array([1.0, -0.5])
    wave = f_s / root(2.0 * b)  # of a port at rest
    master = Port(MasterParams(impedance=25.0, hold="zoh"), axes=2)
    master.receive(-wave)
    f_m = master.step(np.zeros(2), np.zeros(2))
    np.testing.assert_allclose(f_m, root(2.0 * 25.0) * (f_s / root(2.0 * b)), rtol=1e-12)
