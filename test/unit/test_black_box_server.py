# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The port of an unknown environment: its equations, its library, batches."""

import numpy as np
import pytest

from pmwvc_core.controllers.ends import make_server
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import COMPENSATIONS, INTEGRATORS
from pmwvc_core.server.black_box.port import BlackBoxServer
from pmwvc_core.server.compensations import COMPENSATIONS as MADE

B_W = 25.0


def make(coupling, *, users=1, dof=1, contact="bilateral", k=500.0, damping=3.0, b=None, **values):
    contacts = ContactParams(
        contact=contact, contact_stiffness=k, contact_damping=damping, gap_m=0.002
    )
    sides = [-1 if i % 2 == 0 else 1 for i in range(users)]
    params = ServerParams(coupling=coupling, **{"decoding": "late", **values})
    impedances = [B_W if b is None else b] * users
    return make_server("pmwvc", params, [contacts] * users, impedances, dof=dof, sides=sides)


def white(users, dof, *, steps=200, size=0.5, seed=3):
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        rows = rng.normal(0.0, size, (users, dof))
        yield [float(row[0]) if dof == 1 else row for row in rows]


def seat_all(server, dof):
    for user in range(len(server.ports)):
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
        assert np.squeeze(unknown.potential) == pytest.approx(np.squeeze(known.potential))


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
    assert np.squeeze(sloped.accounts["late_decoding"]) == pytest.approx(0.0, abs=1e-12)


def test_with_its_slope_a_nonlinear_contact_is_met_nearly():
    """What the line misses is late decoding; the force of the step before misses more."""
    missed = {}
    for name in ("with", "without"):
        server = make("unknown", environment="hunt_crossley", k=3e4, compensation="none")
        if name == "without":
            environment = server._asked.environment

            class Hidden:
                join, step = environment.join, environment.step

            server._asked.environment = Hidden()
        server.join(0, -0.03)
        for n in range(400):
            server.step([0.3 * np.sin(2.0 * np.pi * n / 100.0)])
        missed[name] = -server.accounts["late_decoding"]
    assert missed["without"] > 0.0
    assert abs(missed["with"]) < 0.5 * missed["without"]


@pytest.mark.parametrize("contact", ["bilateral", "grip"])
@pytest.mark.parametrize("dof", [1, 2])
def test_the_cube_as_a_black_box_accounts_for_its_energy(contact, dof):
    """Work of the avatars: what is stored, and heat that only grows."""
    server = make("unknown", users=3, dof=dof, contact=contact, object_damping=2.0)
    seat_all(server, dof)
    lost = 0.0
    for wave in white(3, dof):
        server.step(wave)
        assert np.squeeze(server.dissipated) >= lost - 1e-13
        lost = float(np.squeeze(server.dissipated))
    assert np.squeeze(server.potential) > 0.0


def test_a_soft_body_pushes_by_its_law():
    """Pressed with F it yields d = (F/K)^(1/n)."""
    server = make("unknown", environment="hunt_crossley", k=3000.0)
    server.join(0, -0.032)
    for _ in range(4000):
        server.step([2.0 / (2.0 * B_W) ** 0.5])
    depth = (2.0 / 3000.0) ** (1.0 / 1.5)
    assert server.f_s[0] == pytest.approx(2.0)
    assert server.x_s[0] == pytest.approx(-0.03 + depth)
    assert server.potential == pytest.approx(3000.0 * depth**2.5 / 2.5)
    for _ in range(400):
        server.step([-0.5])
    assert server.f_s[0] == 0.0


@pytest.mark.parametrize(
    ("compensation", "decoding"),
    [*((compensation, "late") for compensation in COMPENSATIONS), ("ledger", "secant")],
)
@pytest.mark.parametrize("environment", ["wall", "cube", "hunt_crossley", "active_wall"])
def test_a_batch_is_the_same_as_its_runs_one_by_one(compensation, decoding, environment):
    runs = 3
    values = {"compensation": compensation, "decoding": decoding, "environment": environment}
    impedances, stiffness = np.array([10.0, 25.0, 60.0]), np.array([300.0, 900.0, 2500.0])

    def server(k, b):
        return make("unknown", users=2, contact="grip", k=k, b=b, **values)

    singles = [server(float(k), float(b)) for k, b in zip(stiffness, impedances, strict=True)]
    batch = server(stiffness[:, np.newaxis], impedances[:, np.newaxis])
    for user, place in enumerate((-0.03, 0.03)):
        batch.join(user, np.full((runs, 1), place))
        for single in singles:
            single.join(user, place)
    rng = np.random.default_rng(9)
    for _ in range(80):
        waves = rng.normal(0.0, 0.3, (2, runs, 1))
        batch.step(list(waves))
        for run, single in enumerate(singles):
            single.step(waves[:, run, 0].tolist())
            for name in ("v_s", "x_s", "f_s"):
                np.testing.assert_allclose(
                    [value[run, 0] for value in getattr(batch, name)],
                    getattr(single, name),
                    rtol=1e-9,
                    atol=1e-12,
                )
            assert batch.accounts.keys() == single.accounts.keys()
            for name, value in single.accounts.items():
                both = np.broadcast_to(batch.accounts[name], (runs, 1))
                assert both[run, 0] == pytest.approx(value, rel=1e-9, abs=1e-12)


def test_a_slope_may_be_one_number():
    class Damper:
        def local(self, position, dt):
            return 0.0, 15.0

        def step(self, position, velocity, dt):
            return 15.0 * velocity

    server = BlackBoxServer(ServerParams(coupling="unknown"), make("unknown").ports, Damper())
    server.join(0, 0.0)
    server.step([1.0])
    assert server.xd_s[0] == pytest.approx((2.0 * B_W) ** 0.5 / (B_W + 15.0))
    assert server.accounts["late_decoding"] == pytest.approx(0.0, abs=1e-15)
