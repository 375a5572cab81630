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
from pmwvc_core.params import ContactParams, MasterParams, ServerParams
from pmwvc_core.params.server import HuntCrossleyParams
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


def joined(server, environment=None, users=2, **given):
    contact = given.pop("contact", CONTACT)
    rig = Users(server, [contact] * users, b=B_W, environment=environment, **given)
    for user in range(users):
        rig.join(user, np.r_[0.032 * (2 * user - 1), np.zeros(rig.axes - 1)])  # outside a face
    return rig


MATRIX = [MasterParams(impedance_matrix="30 6 0; 6 20 4; 0 4 25")] * 2


@settings(max_examples=20)
@given(
    seed=st.integers(0, 2**32 - 1),
    name=st.sampled_from(["cube", "wall"]),
    contact=st.sampled_from(["bilateral", "grip"]),
    masters=st.sampled_from([None, MATRIX]),
)
def test_the_librarys_are_the_implicit_coupling(seed, name, contact, masters):
    """K T/b is 20. The control: decoding along a learned slope is far from that."""
    rng, given = np.random.default_rng(seed), {"axes": 3, "masters": masters}
    given["contact"] = ContactParams(
        contact=contact, contact_stiffness=3e4, contact_damping=7.0, gap_m=0.001
    )
    unknown = {"coupling": "unknown", "compensation": "none", "object_damping": 3.0}
    known = joined(ServerParams(environment=name, object_damping=3.0), **given)
    met = joined(ServerParams(environment=f"{name}_with_impedance", **unknown), **given)
    guessed = joined(ServerParams(environment=name, **unknown), **given)
    apart, wave, most = 0.0, np.zeros((2, 3)), 0.0
    for _ in range(300):
        wave = 0.9 * wave + rng.normal(0.0, 0.3, (2, 3))
        wanted = known.step(list(wave))
        np.testing.assert_allclose(met.step(list(wave)), wanted, atol=1e-9)
        apart = max(apart, float(np.abs(np.array(guessed.step(list(wave))) - wanted).max()))
        most = max(most, abs(known.s.ports[0].avatar.f[0]))
    assert apart > 0.1 or most == 0.0
    assert met.energies["late_decoding"] == 0.0


@settings(max_examples=20)
@given(
    seed=st.integers(0, 2**32 - 1),
    stiffness=st.floats(1e2, 1e6),
    exponent=st.floats(1.0, 3.0),
    damping=st.floats(0.0, 20.0),
)
def test_the_librarys_soft_body_is_its_law(seed, stiffness, exponent, damping):
    """Against brentq, for any law: force and end of the step fit, and no energy comes out."""
    rng, law = np.random.default_rng(seed), HuntCrossleyParams(exponent, damping)
    server = ServerParams(
        coupling="unknown", environment="hunt_crossley_with_impedance", compensation="none",
        hunt_crossley=law,
    )  # fmt: skip
    rig = joined(server, users=1, contact=ContactParams(contact_stiffness=stiffness))
    wave, least_j, touched = 0.0, 0.0, 0

    def excess(xd, x, u):
        depth = max(x + H * xd + 0.5 * server.object_size_m, 0.0)
        push = stiffness * depth**exponent * max(1.0 + damping * xd, 0.0)
        return np.sqrt(2.0 * B_W) * u - B_W * xd - push

    for _ in range(200):
        wave = 0.9 * wave + rng.normal(0.1, 0.3)
        x = rig.s.ports[0].x_s[0]
        rig.step([wave])
        xd = brentq(excess, -20.0, 20.0, args=(x, wave), xtol=1e-14, rtol=1e-14)
        assert rig.s.ports[0].avatar.xd[0] == pytest.approx(xd, abs=1e-9)
        least_j = min(least_j, rig.taken_j)
        touched += rig.s.ports[0].avatar.f[0] > 0.0
    assert touched > 0 and least_j >= -1e-12
    assert rig.energies["late_decoding"] == pytest.approx(0.0, abs=1e-12)


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
    assert met.energies["late_decoding"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"server.integrator": "trapezoid"}, "set server.integrator = backward_euler"),
        ({"dof": 2, "master.impedance_matrix": "9 1; 1 9"}, "remove impedance_matrix"),
        ({"dof": 6, "channel": "strict"}, "six axes with channel = strict need couples = True"),
    ],
)
def test_what_an_answer_to_an_impedance_cannot_be_is_refused(monkeypatch, values, words):
    offer(monkeypatch, PLUGINS.group, "lab_soft", {"soft": lambda setup: Springs(1, 0.0)})
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
