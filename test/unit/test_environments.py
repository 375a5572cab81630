# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments by name, and the wall."""

import pytest
from support.law_rigs import Users

from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import COUPLINGS, KNOWN
from pmwvc_core.server.environments import LIBRARY


def test_every_environment_a_parameter_can_name_exists():
    assert tuple(name for name, record in LIBRARY.items() if record.known) == KNOWN
    assert all(record.made for record in LIBRARY.values())


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("contact", ["bilateral", "grip"])
def test_pressed_steadily_a_wall_shows_its_stiffness(coupling, contact):
    """In rest nothing moves: u = sqrt(b/2) F/b, and the avatar is F/K in, under every coupling."""
    b, k, force = 25.0, 400.0, 2.0
    server = Users(
        ServerParams(coupling=coupling, environment="wall"),
        [ContactParams(contact=contact, contact_stiffness=k, contact_damping=5.0)],
        b=b,
    )
    server.join(0, -0.03)
    for _ in range(4000):
        server.step([force / (2 * b) ** 0.5])
    assert server.f_s[0] == pytest.approx(force)
    assert server.x_s[0] == pytest.approx(-0.03 + force / k)
    assert server.xd_s[0] == pytest.approx(0.0, abs=1e-12)
    assert server.v_s[0] == pytest.approx(-force / (2 * b) ** 0.5)
    assert server.touches(0)
    assert server.energies["potential"] == pytest.approx(0.5 * force**2 / k)
    assert server.x_o == 0.0


@pytest.mark.parametrize("coupling", COUPLINGS)
def test_a_one_sided_wall_lets_go(coupling):
    server = Users(
        ServerParams(coupling=coupling, environment="wall"),
        [ContactParams(contact_stiffness=400.0, contact_damping=5.0, gap_m=0.01)],
        sides=[1],
    )
    server.join(0, 0.0)
    assert server.x_s[0] == pytest.approx(0.04)
    assert server.offset[0] == pytest.approx(0.04)
    for wave, touching in ((-0.5, True), (0.5, False)):
        for _ in range(60):
            server.step([wave])
        assert server.touches(0) == touching
    assert server.f_s[0] == 0.0
    assert server.v_s[0] == wave
