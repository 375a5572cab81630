# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The port of an unknown environment: its equations, its library."""

import numpy as np
import pytest
from support.law_rigs import Users

from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import COMPENSATIONS, INTEGRATORS
from pmwvc_core.server.couplings import COMPENSATIONS as MADE

B_W = 25.0


def make(
    coupling,
    *,
    users=1,
    dof=1,
    contact="bilateral",
    k=500.0,
    damping=3.0,
    b=None,
    around=None,
    **values,
):
    contacts = ContactParams(
        contact=contact, contact_stiffness=k, contact_damping=damping, gap_m=0.002
    )
    params = ServerParams(coupling=coupling, **{"decoding": "late", **values})
    return Users(
        params, [contacts] * users, b=B_W if b is None else b, axes=dof, environment=around
    )


def white(users, dof, *, steps=200, size=0.5, seed=3):
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        rows = rng.normal(0.0, size, (users, dof))
        yield [float(row[0]) if dof == 1 else row for row in rows]


def seat_all(server, dof):
    for user in range(len(server.s.ports)):
        place = np.full(dof, -0.032 if user % 2 == 0 else 0.032)  # the gap before the face
        server.join(user, float(place[0]) if dof == 1 else place)


def signals(server):
    return np.array([*server.x_s, *server.xd_s, *server.f_s, *server.v_s], float)


def test_every_compensation_a_parameter_can_name_exists():
    assert tuple(MADE.library) == COMPENSATIONS


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("contact", ["bilateral", "grip"])
@pytest.mark.parametrize("dof", [1, 3])
def test_without_compensation_a_wall_is_one_step_delay(integrator, contact, dof):
    known, unknown = (
        make(name, dof=dof, contact=contact, integrator=integrator, environment="wall", **more)
        for name, more in (("one_step_delay", {}), ("unknown", {"compensation": "none"}))
    )
    for server in (known, unknown):
        seat_all(server, dof)
    for wave in white(1, dof):
        known.step(wave)
        unknown.step(wave)
        np.testing.assert_allclose(signals(unknown), signals(known), rtol=1e-9, atol=1e-11)
        assert unknown.energies["potential"] == pytest.approx(known.energies["potential"])


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("dof", [1, 3])
def test_with_its_slope_the_loop_of_a_linear_wall_is_solved(integrator, dof):
    """App. C Eq. 4, whose solution the coupling ``unwrapped`` has in closed form."""
    solved = make("unwrapped", dof=dof, integrator=integrator, environment="wall")
    sloped = make(
        "unknown",
        dof=dof,
        integrator=integrator,
        environment="wall_with_slope",
        compensation="none",
    )
    for server in (solved, sloped):
        seat_all(server, dof)
    for wave in white(1, dof):
        solved.step(wave)
        sloped.step(wave)
        np.testing.assert_allclose(signals(sloped), signals(solved), rtol=1e-9, atol=1e-12)
    assert sloped.energies["late_decoding"] == pytest.approx(0.0, abs=1e-12)


class Soft:
    """A soft body F = K d^(3/2) that may tell its slope."""

    def step(self, position, velocity, dt):
        return 3e4 * np.maximum(position + 0.03, 0.0) ** 1.5


class SoftSloped(Soft):
    def local(self, position, dt):
        depth = np.maximum(position + 0.03, 0.0)
        return 3e4 * depth**1.5, 4.5e4 * depth**0.5 * dt


def test_with_its_slope_a_nonlinear_contact_is_met_nearly():
    """What the line misses is late decoding; the force of the step before misses more."""
    missed = []
    for body in (Soft(), SoftSloped()):
        server = make("unknown", around=body, compensation="none")
        server.join(0, -0.03)
        for n in range(400):
            server.step([0.3 * np.sin(2.0 * np.pi * n / 100.0)])
        missed.append(-server.energies["late_decoding"])
    assert missed[0] > 0.0
    assert abs(missed[1]) < 0.5 * missed[0]


@pytest.mark.parametrize("contact", ["bilateral", "grip"])
@pytest.mark.parametrize("dof", [1, 2])
def test_the_cube_as_a_black_box_accounts_for_its_energy(contact, dof):
    """Work of the avatars: what is stored, and heat that only grows."""
    server = make("unknown", users=3, dof=dof, contact=contact, object_damping=2.0)
    seat_all(server, dof)
    lost = 0.0
    for wave in white(3, dof):
        server.step(wave)
        assert server.dissipated >= lost - 1e-13
        lost = server.dissipated
    assert server.stored > 0.0


def test_a_soft_body_pushes_by_its_law():
    """Pressed with F it yields d = (F/K)^(1/n)."""
    server = make("unknown", environment="hunt_crossley", k=3000.0)
    server.join(0, -0.032)
    for _ in range(4000):
        server.step([2.0 / (2.0 * B_W) ** 0.5])
    depth = (2.0 / 3000.0) ** (1.0 / 1.5)
    assert server.f_s[0] == pytest.approx(2.0)
    assert server.x_s[0] == pytest.approx(-0.03 + depth)
    assert server.energies["potential"] == pytest.approx(3000.0 * depth**2.5 / 2.5)
    for _ in range(400):
        server.step([-0.5])
    assert server.f_s[0] == 0.0


def test_a_slope_may_be_one_number():
    class Damper:
        def local(self, position, dt):
            return 0.0, 15.0

        def step(self, position, velocity, dt):
            return 15.0 * velocity

    server = make("unknown", around=Damper())
    server.join(0, 0.0)
    server.step([1.0])
    assert server.xd_s[0] == pytest.approx((2.0 * B_W) ** 0.5 / (B_W + 15.0))
    assert server.energies["late_decoding"] == pytest.approx(0.0, abs=1e-15)
