# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The implicit step behind matrix impedances settles at wild settings, or says that it did not."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from support import plain as scenarios
from support.laws import as_written

from pmwvc_core.controllers.ends import make_server
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.wave.impedance import MatrixImpedance


def wild(rng):
    """Return a server with matrices of condition up to 1e6, and random everything."""
    dof, users = int(rng.integers(2, 7)), int(rng.integers(1, 5))
    impedances = []
    for _ in range(users):
        axes, _ = np.linalg.qr(rng.normal(size=(dof, dof)))
        impedances.append(MatrixImpedance(np.sort(10.0 ** rng.uniform(-3.0, 3.0, dof)), axes))
    params = ServerParams(
        period_s=float(rng.choice([0.001, 0.008, 0.05])),
        object_mass=float(10.0 ** rng.uniform(-3.0, 3.0)),
    )
    contact = ContactParams(
        contact_stiffness=float(10.0 ** rng.uniform(1.0, 6.0)),
        contact_damping=float(rng.choice([0.0, 10.0 ** rng.uniform(-1.0, 4.0)])),
    )
    sides = [-1 if i % 2 == 0 else 1 for i in range(users)]
    server = make_server("pmwvc", params, [contact] * users, impedances, dof=dof, sides=sides)
    for user in range(users):
        server.join(user, rng.normal(0.0, 0.03, dof))
    return server, dof


def play(server, dof, rng, *, steps=20):
    """Step with waves of any size; return the unexplained energy over what moved."""
    for _ in range(steps):
        size = rng.choice([0.1, 1.0, 10.0])
        server.step([size * rng.normal(size=dof) for _ in server.ports])
    into, out = (
        sum(float(np.squeeze(energy)) for energy in energies)
        for energies in (server.energy_u_s, server.energy_v_s)
    )
    held = sum(float(np.squeeze(e)) for e in (server.kinetic, server.potential, server.dissipated))
    return abs(into - out - held) / (into + out)


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_wild_matrices_settle_and_energy_balances(seed):
    rng = np.random.default_rng(seed)
    server, dof = wild(rng)
    left = play(server, dof, rng)
    if server.faults.steps == 0:
        assert left < 1e-7
    else:
        assert "did not settle" in server.faults.text


def test_hardly_any_of_many_wild_settings_is_left_unsettled():
    rng = np.random.default_rng(11)
    flagged = 0
    for _ in range(60):
        server, dof = wild(rng)
        play(server, dof, rng, steps=10)
        flagged += server.faults.steps > 0
    assert flagged == 0


def test_an_unsettled_step_is_reported(monkeypatch):
    """The control: without iterations the equation is not solved, and the session says so."""
    as_written(monkeypatch, server__implicit_coupled__STEPS=0)
    matrix = "master.impedance_matrix=30 6 0; 6 20 4; 0 4 25"
    scenario = scenarios.load("cube_3d", users=1, duration_s=3.0, settings_texts=[matrix])
    traces = simulate_one(scenario)
    (event,) = [each for each in traces.events if each["kind"] == "environment"]
    assert "server.coupling = 'implicit' did not settle" in event["what"]


def test_a_session_that_settles_tells_nothing():
    assert simulate_one(scenarios.load("cube_3d", users=1, duration_s=3.0)).events == []
