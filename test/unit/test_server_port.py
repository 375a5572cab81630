# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server as a whole: joining, leaving, accounts, axes."""

import numpy as np
import pytest
from support.law_rigs import Users

from pmwvc_core.law.server.contacts import contact_energy
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import COUPLINGS
from pmwvc_core.server.couplings import COUPLINGS as RECORDS

H, B_W = 0.008, 25.0
CONTACTS = ("bilateral", "grip")


def make(users, *, coupling="implicit", contact="grip", dof=1, environment="cube", **values):
    # A learned slope is one of the whole vector: late decoding keeps the axes apart.
    server = ServerParams(coupling=coupling, environment=environment, decoding="late")
    return Users(server, [ContactParams(contact=contact, **values)] * users, b=B_W, axes=dof)


def squeeze(server, steps, *, force=1.0, users=(0, 1)):
    """Press from both sides with ``force`` N for some steps."""
    waves = [0.0] * len(server.s.ports)
    for i in users:
        waves[i] = (force if i % 2 == 0 else -force) / np.sqrt(2 * B_W)
    for _ in range(steps):
        server.step(waves)


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("contact", CONTACTS)
def test_joining_stores_no_energy_and_makes_no_force(coupling, contact):
    server = make(4, coupling=coupling, contact=contact)
    server.join(0, -0.03)
    server.join(1, 0.03)
    squeeze(server, 800)
    before = server.stored, server.x_o, list(server.f_s)
    server.join(2, -0.01)
    server.join(3, 0.2)
    assert server.stored == before[0]
    assert server.x_o == before[1]
    assert server.f_s == before[2]
    assert server.f_s[2] == server.f_s[3] == 0.0
    assert server.present == [True] * 4


@pytest.mark.parametrize(
    "coupling", [name for name, one in RECORDS.library.items() if not one.black_box]
)
@pytest.mark.parametrize("contact", CONTACTS)
def test_leaving_drops_the_spring_and_nothing_more(coupling, contact):
    server = make(2, coupling=coupling, contact=contact)
    server.join(0, -0.03)
    server.join(1, 0.03)
    squeeze(server, 2000)
    total, spring = server.stored, contact_energy(server.s.ports[1].avatar.contact)
    lost = server.dissipated
    assert spring == pytest.approx(0.5 * 1.0**2 / 500.0)
    server.leave(1)
    assert server.stored == pytest.approx(total - spring)
    assert server.dissipated == pytest.approx(lost + spring)
    assert server.present == [True, False]
    assert not server.touches(1)
    assert server.f_s[1] == 0.0


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("contact", CONTACTS)
def test_waves_of_any_size_get_finite_answers(coupling, contact):
    """Depths shrink through the smallest numbers there are; their squares vanish first."""
    for k in (0.0, 1e5) if coupling == "implicit" else (0.0,):  # the others are not passive
        server, wave = make(2, coupling=coupling, contact=contact, contact_stiffness=k), 1e4
        server.join(0, -0.03)
        server.join(1, 0.03)
        while wave != 0.0:
            returned = server.step([wave, -0.9 * wave])
            assert np.isfinite([*returned, server.x_o, server.dissipated]).all()
            wave *= -0.2
