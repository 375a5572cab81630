# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Direct coupling: positions up, forces down."""

import numpy as np
import pytest
from support.law_rigs import Port, Users

from pmwvc_core.params import ContactParams, MasterParams, ServerParams

H = 0.008


def make(users=2, *, contact="grip", environment="cube", dof=1, **values):
    contacts = [ContactParams(contact=contact, **values)] * users
    server = ServerParams(environment=environment)
    return Users(server, contacts, controller="direct", axes=dof)


def test_the_avatar_stands_where_the_device_is():
    server = make(contact="bilateral")
    server.join(0, 0.1)
    server.join(1, -0.1)
    forces = server.step([(0.102, 0.0), (-0.1, 0.05)])
    assert server.x_s == [0.102, -0.1]
    assert forces == pytest.approx([500.0 * 0.002, 10.0 * 0.05])


def test_the_cube_moves_under_the_forces_held_since():
    server = make(1, contact="bilateral")
    server.join(0, 0.0)
    server.step([(0.002, 0.0)])
    assert server.x_o == 0.0
    server.step([(0.002, 0.0)])
    assert server.x_o == pytest.approx(H**2 / 2 / 2.0 * 1.0)
    assert server.xd_o == pytest.approx(H / 2.0 * 1.0)
    assert server.f_s[0] == pytest.approx(500.0 * (0.002 - server.x_o) - 10.0 * server.xd_o)


@pytest.mark.parametrize("dof", [1, 3])
def test_a_grip_starts_outside_and_keeps_its_offset(dof):
    server = make(1, environment="wall", dof=dof)
    at = 0.0 if dof == 1 else np.zeros(3)
    inwards = 1.0 if dof == 1 else np.array([1.0, 0.0, 0.0])
    server.join(0, at)
    np.testing.assert_allclose(server.offset[0], -0.03 * inwards)
    np.testing.assert_array_equal(server.step([(at, at)])[0], 0.0 * inwards)
    np.testing.assert_allclose(server.step([(at + 0.002 * inwards, at)])[0], 1.0 * inwards)
    np.testing.assert_array_equal(server.step([(at - 0.002 * inwards, at)])[0], 0.0 * inwards)


def test_who_left_gets_no_force_and_pushes_no_more():
    server = make(1, contact="bilateral")
    server.join(0, 0.0)
    server.step([(0.01, 0.0)])
    server.leave(0)
    assert server.step([(0.01, 0.0)]) == [0.0]
    assert server.xd_o == 0.0
    assert server.dissipated == pytest.approx(0.5 * 500.0 * 0.01**2)


def test_a_slow_bounce_off_a_spring_returns_more_than_it_took():
    """The control for every passivity test: sampled positions make energy out of a spring."""
    server = make(1, contact="bilateral", environment="wall", contact_damping=0.0)
    server.join(0, 0.0)
    omega = 2 * np.pi * 10.0
    for n in range(100):
        held_at = 0.01 * np.sin(omega * n * H)
        # What the device does while the force is held: the mean velocity over the frame to come.
        velocity = 0.01 * (np.sin(omega * (n + 1) * H) - np.sin(omega * n * H)) / H
        server.step([(held_at, velocity)])
    assert server.taken_j < 0.0


class TestMaster:
    def made(self):
        return Port(MasterParams(tick_s=0.001), controller="direct")

    def test_it_sends_what_was_last_measured(self):
        master = self.made()
        assert (master.send(), master.x) == (0.0, 0.0)
        master.step(0.01, 0.2)
        assert (master.send(), master.x) == (0.2, 0.01)
        master.measure(0.0102, 0.21)
        assert (master.send(), master.x) == (0.21, 0.0102)

    def test_it_holds_the_force_it_got_until_the_next_and_lets_go_in_silence(self):
        master = self.made()
        assert master.step(0.0, 1.0) == 0.0
        master.receive(1.5)
        assert [master.step(0.0, 1.0) for _ in range(20)] == [1.5] * 20
        master.receive(-0.5)
        assert master.step(0.0, 1.0) == -0.5
        master.silence()
        assert master.step(0.0, 1.0) == 0.0

    def test_it_books_the_force_that_was_applied(self):
        master = self.made()
        master.receive(2.0)
        for velocity in (0.5, -0.25):
            master.step(0.0, velocity)
            master.applied(1.0)  # limited on the way
        energies = master.energies
        assert energies["u_m"] == energies["u_tx"] == pytest.approx(0.0005)
        assert energies["v_m"] == energies["v_rx"] == pytest.approx(0.00025)
        assert master.u_m == master.u_m_lp == master.v_m == 0.0
