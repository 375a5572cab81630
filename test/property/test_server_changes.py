# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a running server change without energy, without a jump of any avatar."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import plain as files
from support.law_rigs import Users

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_core.law.server.contacts import offset_of
from pmwvc_core.law.server.server_port import changed_port
from pmwvc_core.made.server import changed_server
from pmwvc_core.made.waves import made_impedance
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.simulation.session import simulate_one

PERIOD_S = 0.008
stiffnesses = st.one_of(st.just(0.0), st.floats(1e-2, 1e5))
contacts = st.builds(
    ContactParams,
    impedance=st.floats(1.0, 300.0),
    contact_stiffness=stiffnesses,
    contact_damping=st.floats(0.0, 200.0),
)
servers = st.builds(
    ServerParams,
    environment=st.sampled_from(["cube", "cube", "wall"]),
    object_mass=st.floats(0.05, 50.0),
    object_damping=st.floats(0.0, 50.0),
)
COUPLINGS = ["implicit", "one_step_delay", "one_frame_late", "unwrapped"]
contents = st.sampled_from(["bilateral", "grip"])


class Step(NamedTuple):
    """The part of a step's parameters that changes here."""

    environment: Any


class Server(Users):
    """Two users at their faces, and the server's parameters that change."""

    def __init__(self, contact, *, server=None, dof=1, kind="grip"):
        self._made = [replace(contact, contact=kind)] * 2, dof
        super().__init__(server or ServerParams(), self._made[0], axes=dof)
        for i, place in enumerate((-0.03, 0.03)):
            self.join(i, np.array([place] + [0.0] * (dof - 1)))
        assert all(self.present)

    def configure_user(self, user, contact, b):
        law = contact.contact_stiffness, contact.contact_damping, made_impedance(b)
        self._changed(user, *changed_port(self.s.ports[user], *law))

    def configure(self, params):
        wanted = Users(params, self._made[0], axes=self._made[1]).p
        self.s, self.p = changed_server(self.s, Step(self.p), Step(wanted)), wanted

    def contact(self, user):
        return self.s.ports[user].avatar.contact

    def face(self, user):
        return self.contact(user).springs[0].rest

    @property
    def potential(self):
        return self.energies["potential"]


def energy(server):
    return server.stored + server.dissipated


def state(server):
    """What a person would see: places of avatars and object."""
    return np.array([server.s.body.x, *(place(server, i) for i in (0, 1))])


def place(server, user):
    return np.add(server.s.body.x, offset_of(server.contact(user)))


def waves(rng, dof, size):
    """Waves that press users together, with noise."""
    push = np.array([1.0, *[0.0] * (dof - 1)])
    noise = rng.normal(0.0, 0.5, (2, dof))
    found = [size * (push + noise[0]), size * (-push + noise[1])]
    return [each if dof > 1 else float(each[0]) for each in found]


@settings(max_examples=20)
@given(
    first=servers,
    coupling=st.sampled_from(COUPLINGS),
    contact=contacts,
    kind=contents,
    dof=st.sampled_from([1, 3]),
    changes=st.lists(st.tuples(st.integers(0, 1), contacts, servers), min_size=1, max_size=8),
    size=st.sampled_from([0.01, 0.5, 2.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_change_keeps_the_energy_and_the_places(
    first, coupling, contact, kind, dof, changes, size, seed
):
    rng = np.random.default_rng(seed)
    first = replace(first, coupling=coupling)
    server = Server(contact, server=first, dof=dof, kind=kind)
    for user, other, params in changes:
        for _ in range(6):
            server.step(waves(rng, dof, size))
        before, seen = energy(server), state(server)
        server.configure_user(user, replace(other, contact=kind), other.impedance)
        params = replace(params, environment=first.environment)
        server.configure(replace(params, coupling=COUPLINGS[int(rng.integers(4))]))
        assert energy(server) == pytest.approx(before, rel=1e-9, abs=1e-15)
        rounding = 1e-15 * max(1.0, float(np.abs(seen).max()))  # places are sums of such lengths
        np.testing.assert_allclose(state(server), seen, rtol=1e-12, atol=rounding)


@settings(max_examples=20)
@given(contact=contacts, kind=contents, dof=st.sampled_from([1, 3]), seed=st.integers(0, 1000))
def test_a_change_to_what_is_already_so_moves_no_bit(contact, kind, dof, seed):
    rng = np.random.default_rng(seed)
    server = Server(contact, dof=dof, kind=kind)
    for _ in range(20):
        server.step(waves(rng, dof, 0.5))
    before = server.s
    server.configure_user(0, replace(contact, contact=kind), contact.impedance)
    assert server.s == before


def pressed(kind="grip"):
    """A server whose users press on a wall, one from each side."""
    wall = ServerParams(environment="wall")
    contact = ContactParams(contact_stiffness=500.0, contact_damping=10.0, impedance=25.0)
    server = Server(contact, server=wall, kind=kind)
    for _ in range(40):
        server.step([0.2, -0.2])
    assert server.potential > 1e-3
    return server, replace(contact, contact_stiffness=3000.0)


@pytest.mark.parametrize("kind", ["bilateral", "grip"])
def test_stiffness_raised_as_it_is_adds_energy_and_raised_properly_none(kind):
    """The control: the naive change multiplies the energy of the spring."""
    server, stiff = pressed(kind)
    naive, _ = pressed(kind)
    before = server.potential
    for i in (0, 1):
        server.configure_user(i, stiff, 25.0)
        port = naive.s.ports[i]
        law = port.avatar.contact.law._replace(stiffness=stiff.contact_stiffness)
        contact = port.avatar.contact._replace(law=law)
        naive._changed(i, port._replace(avatar=port.avatar._replace(contact=contact)), 0.0)
    assert server.potential == pytest.approx(before, rel=1e-12)
    assert naive.potential == pytest.approx(6.0 * before, rel=1e-12)


@pytest.mark.parametrize("stiffness", [50.0, 3000.0])
def test_the_face_goes_back_once_the_avatar_has_left(stiffness):
    server, stiff = pressed()
    face = server.face(0)
    server.configure_user(0, replace(stiff, contact_stiffness=stiffness), 25.0)
    assert server.face(0) != face
    for _ in range(400):
        before, there = energy(server), place(server, 0)
        received = [-0.2, -0.2]
        returned = server.step(received)
        into = 0.5 * PERIOD_S * (0.08 - sum(v * v for v in returned))
        assert energy(server) - before == pytest.approx(into, abs=1e-12)
        assert place(server, 0) < there  # no step backwards
        if server.contact(0).springs[0].rest == server.contact(0).law.face:
            break
    assert server.face(0) == face


def test_a_spring_that_is_taken_away_loses_its_energy_as_heat():
    server, stiff = pressed()
    before, total = server.dissipated, energy(server)
    server.configure_user(0, replace(stiff, contact_stiffness=0.0), 25.0)
    assert server.dissipated > before
    assert energy(server) == pytest.approx(total, rel=1e-12)
    server.configure_user(0, stiff, 25.0)  # and comes back without any
    assert energy(server) == pytest.approx(total, rel=1e-12)


def test_a_wall_has_no_energy_of_motion_to_change():
    server, _ = pressed()
    server.configure(ServerParams(environment="wall", object_mass=9.0))
    assert server.energies["kinetic"] == 0.0


@pytest.mark.parametrize(
    "setting",
    [
        "user2.server.contact_stiffness=800",
        "user2.server.impedance=40",
        "user1.server.impedance=40",
    ],
)
def test_beside_a_matrix_a_number_changes_as_ever(setting):
    """One of the users behind a matrix; in the last case none is any more."""
    texts = ["dof=2", "user1.master.impedance_matrix=30 2; 2 20", f"changes=1 {setting}"]
    scenario = files.load("carry_16ms", settings_texts=texts, duration_s=2.0)
    traces = simulate_one(scenario)
    found = passivity(traces, scenario, budget(traces, scenario))
    assert found.session is True
