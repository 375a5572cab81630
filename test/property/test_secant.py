# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Decoding along a learned slope: what is learned, and how a wall is then rendered."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import Users

from pmwvc_core.law.black_box.secant import LARGEST, REPAID, learn, resting_secant
from pmwvc_core.params import ContactParams, ServerParams

PERIOD_S = 0.02


def learned(spring, places):
    """Show a bilateral spring (matrix) to what learns; return the slope."""
    secant = resting_secant((0.0,) * len(spring), 1250.0, False)
    for place in places:
        secant = learn(secant, tuple(place.tolist()), tuple((spring @ place).tolist()), True)
    return np.array(secant.slope)


@pytest.mark.parametrize("dof", [1, 2, 3])
def test_a_linear_spring_is_learned(dof):
    rng = np.random.default_rng(dof)
    root = rng.normal(size=(dof, dof))
    spring = 500.0 * root @ root.T
    found = learned(spring, np.cumsum(rng.normal(0.0, 1e-3, (400, dof)), axis=0))
    np.testing.assert_allclose(found, spring, rtol=0.05, atol=0.05 * np.abs(spring).max())


@settings(max_examples=20)
@given(
    dof=st.integers(1, 4),
    seed=st.integers(0, 2**32 - 1),
    size=st.sampled_from([1e-6, 1e-3, 1.0]),
    force=st.sampled_from([1e-3, 1.0, 1e5]),
)
def test_the_slope_stays_semidefinite_and_bounded_whatever_comes_back(dof, seed, size, force):
    rng = np.random.default_rng(seed)
    secant = resting_secant((0.0,) * dof, 1000.0, False)
    for _ in range(100):
        place = size * rng.normal(size=dof)
        came = force * rng.normal(size=dof) * rng.integers(0, 2)
        good = bool(rng.random() < 0.9)
        secant = learn(secant, tuple(place.tolist()), tuple(came.tolist()), good)
        slope = np.array(secant.slope)
        values = np.linalg.eigvalsh(slope)
        np.testing.assert_allclose(slope, slope.T, rtol=1e-12, atol=1e-9 * max(values.max(), 1.0))
        assert values.min() >= -1e-9 * max(values.max(), 1.0)
        assert np.isfinite(values).all()
        if dof == 1:
            assert values.max() <= LARGEST * 1000.0 * (1.0 + 1e-9)


def wall(decoding, *, k, dof=1, environment=None):
    params = ServerParams(
        coupling="unknown", environment="wall", decoding=decoding, period_s=PERIOD_S
    )
    contact = ContactParams(contact="grip", contact_stiffness=k, contact_damping=0.0)
    return Users(params, [contact], axes=dof, environment=environment)


def depth_error(decoding, k, *, dof=1):
    """Return how far the device of a slow press would be from F/K, by what was decoded [m]."""
    server = wall(decoding, k=k, dof=dof)
    start = np.zeros(dof)
    start[0] = -0.03
    server.join(0, float(start[0]) if dof == 1 else start)
    device = -0.03
    for n in range(600):
        force = min(1.0, n / 300.0)
        # A matched hand: the incoming wave that renders this force at rest.
        u = np.zeros(dof)
        u[0] = 2.0 * force / np.sqrt(2.0 * 25.0) / 2.0
        v = server.step([float(u[0]) if dof == 1 else u])[0]
        device += PERIOD_S * float(np.ravel(u + v)[0]) / np.sqrt(2.0 * 25.0)
    return device + 0.03 - float(np.ravel(server.f_s[0])[0]) / k


@pytest.mark.parametrize("dof", [1, 3])
def test_a_stiff_wall_is_pressed_by_its_law(dof):
    """K T = 2.4 b to 9.6 b: decoded late the loop of avatar and wall diverges."""
    for k in (3000.0, 6000.0, 12000.0):
        assert abs(depth_error("secant", k, dof=dof)) < 0.6e-3
        assert abs(depth_error("late", k, dof=dof)) > 5e-3


def test_leaving_and_meeting_a_known_face_is_decoded_with_its_force():
    """Once a spring is known, going in and out of it makes hardly any energy of late decoding."""
    made = {}
    for decoding in ("secant", "late"):
        server = wall(decoding, k=2000.0)
        server.join(0, -0.03)
        for n in range(600):
            if n == 300:
                before = server.energies["late_decoding"]
            server.step([0.1 + 0.3 * np.sin(2.0 * np.pi * n / 100.0)])
        made[decoding] = abs(server.energies["late_decoding"] - before)
    assert made["secant"] < 0.1 * made["late"]


def test_a_face_that_is_gone_is_forgotten_after_one_step():
    class Vanishing:
        here = True

        def step(self, position, velocity, dt):
            depth = np.maximum(position, 0.0)
            return (3000.0 if self.here else 0.0) * depth

    environment = Vanishing()
    server = wall("secant", k=1.0, environment=environment)
    server.join(0, -0.001)
    server.s = server.s._replace(ports=(server.s.ports[0]._replace(x_s=(-0.001,)),))
    for wave in (*[0.2] * 40, -0.3):  # the face was met, and is expected in the next step
        server.step([wave])
    environment.here = False
    moved = []
    for _ in range(30):
        (port,) = server.s.ports
        before = port.x_s[0] + REPAID * port.avatar.kept[0]
        server.step([0.2])
        moved.append(server.x_s[0] - before)
    moved = np.array(moved)
    expected = PERIOD_S * 0.2 * np.sqrt(2.0 / 25.0)
    assert np.flatnonzero(np.abs(moved - expected) > 1e-9).tolist() == [0]
