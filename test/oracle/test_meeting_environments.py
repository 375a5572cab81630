# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments that answer an impedance: with the equations of wall and cube written out here they
give what the implicit coupling gives; with a nonlinear law, the port has that law exactly.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from support.lab import offer
from support.law_rigs import Users

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.server.environments import PLUGINS
from pmwvc_core.simulation.session import simulate

H, B_W = 0.008, 12.0
CONTACT = ContactParams(contact="bilateral", contact_stiffness=900.0, contact_damping=7.0)


class Springs:
    """Two-sided springs between avatars and a body by the midpoint rule; no mass: a wall."""

    def __init__(self, users, mass):
        self.d, self.v, self.mass = np.zeros(users), 0.0, mass

    def meet(self, drive, impedance, dt):
        """f = K (d + dt w/2) + B w, w = xd - v, f = drive - b xd, sum f = m (v1 - v0)/dt."""
        rate, users = CONTACT.contact_stiffness * dt / 2 + CONTACT.contact_damping, len(self.d)
        lhs, rhs = np.zeros((users + 1, users + 1)), np.zeros(users + 1)
        for i in range(users):
            lhs[i, i], lhs[i, -1] = rate + impedance[i], -rate
            rhs[i] = drive[i, 0] - CONTACT.contact_stiffness * self.d[i]
            lhs[-1, i], rhs[-1] = impedance[i], rhs[-1] + drive[i, 0]
        lhs[-1, -1], rhs[-1] = 2.0 * self.mass / dt, rhs[-1] + 2.0 * self.mass * self.v / dt
        if self.mass == 0.0:
            lhs[-1], rhs[-1] = np.eye(users + 1)[-1], 0.0
        *xd, mean = np.linalg.solve(lhs, rhs)
        self.d += dt * (np.array(xd) - mean)
        self.v = 2.0 * mean - self.v
        return np.array(xd)[:, np.newaxis]


class Soft:
    """F = K p^1.5 (1 + c p') at the end of a step, p = x > 0; what the port was told is kept."""

    def __init__(self):
        self.x, self.force = 0.0, 0.0

    def law(self, xd, dt):
        depth = max(self.x + dt * xd, 0.0)
        return 4e5 * depth**1.5 * max(1.0 + 2.0 * xd, 0.0)

    def meet(self, drive, impedance, dt):
        def excess(xd):
            return drive[0, 0] - impedance[0] * xd - self.law(xd, dt)

        xd = brentq(excess, -10.0, 10.0, xtol=1e-15, rtol=1e-15)
        self.force, self.x = self.law(xd, dt), self.x + dt * xd
        return np.full((1, 1), xd)


def joined(server, environment=None, users=2):
    rig = Users(server, [CONTACT] * users, b=B_W, environment=environment)
    for user in range(users):
        rig.join(user, 0.03 * (2 * user - 1))
    return rig


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), name=st.sampled_from(["cube", "wall"]))
def test_springs_written_out_are_the_implicit_coupling(seed, name):
    rng = np.random.default_rng(seed)
    known = joined(ServerParams(environment=name, object_mass=2.0))
    unknown = ServerParams(coupling="unknown", environment=name)
    met = joined(unknown, Springs(2, 2.0 if name == "cube" else 0.0))
    for _ in range(300):
        waves = list(rng.normal(0.0, 0.3, 2))
        np.testing.assert_allclose(met.step(waves), known.step(waves), atol=1e-9)
    for a, b in zip(met.s.ports, known.s.ports, strict=True):
        np.testing.assert_allclose([*a.x_s, *a.avatar.f], [*b.x_s, *b.avatar.f], atol=1e-9)


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(0.05, 2.0))
def test_a_stiff_nonlinear_law_is_rendered_by_itself(seed, size):
    """Nothing is guessed, nothing is late, nothing is limited: K T/b is 20 and more here."""
    rng, soft = np.random.default_rng(seed), Soft()
    rig = joined(ServerParams(coupling="unknown", compensation="none"), soft, users=1)
    wave, least_j = 0.0, 0.0
    for _ in range(300):
        wave = 0.9 * wave + rng.normal(0.1, size)
        rig.step([wave])
        assert rig.s.ports[0].avatar.f[0] == pytest.approx(soft.force, abs=1e-9)
        least_j = min(least_j, rig.taken_j)
    assert rig.energies["late_decoding"] == pytest.approx(0.0, abs=1e-12)
    assert least_j >= -1e-12


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"server.integrator": "trapezoid"}, "set server.integrator = backward_euler"),
        ({"dof": 2, "master.impedance_matrix": "9 1; 1 9"}, "remove impedance_matrix"),
    ],
)
def test_what_an_answer_to_an_impedance_cannot_be_is_refused(monkeypatch, values, words):
    offer(monkeypatch, PLUGINS.group, "lab_soft", {"soft": lambda setup: Soft()})
    mapping = {
        "name": "a",
        "controller": "pmwvc",
        "server": {"coupling": "unknown", "environment": "soft"},
        "users": 1,
        "duration_s": 1,
    }
    scenario = parse_scenario(mapping, source="a test", overrides=values)
    with pytest.raises(ParameterError, match="'soft' answers an impedance") as caught:
        simulate([scenario])
    assert words in str(caught.value)
