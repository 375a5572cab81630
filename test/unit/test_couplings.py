# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The couplings of the server against their equations, written out step by step, and what all of
them do at a wall.
"""

import numpy as np
import pytest
from support.law_rigs import Users

from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import COUPLINGS as NAMES
from pmwvc_core.params.server import INTEGRATORS

H, B_W, K, B_C, M_O = 0.008, 25.0, 500.0, 10.0, 2.0
RATIO = np.sqrt(2.0 / B_W)
PLACES = np.array([-0.03, 0.03])
MEAN_SHARE = {"forward_euler": 0.0, "backward_euler": 1.0, "trapezoid": 0.5}  # of the new velocity


def two_users(coupling, *, contact="bilateral", integrator="backward_euler", **server):
    contacts = ContactParams(contact=contact, contact_stiffness=K, contact_damping=B_C)
    params = ServerParams(coupling=coupling, integrator=integrator, object_mass=M_O, **server)
    made = Users(params, [contacts] * 2, b=B_W)
    for user, place in enumerate(PLACES.tolist()):
        made.join(user, place)
    return made


def random_waves(seed, steps=30):
    return np.random.default_rng(seed).normal(0.0, 0.3, (steps, 2)).tolist()


class Written:
    """Two avatars with two-sided springs at an object: x_s, xd_s, f_s ``(2,)``, x_o and v_o."""

    def __init__(self, share=0.0, b_o=0.0):
        self.x_s, self.xd_s, self.f_s = PLACES.copy(), np.zeros(2), np.zeros(2)
        self.x_o = self.v_o = 0.0
        self.share, self.b_o = share, b_o

    def touch(self):
        stretch = self.x_s - self.x_o - PLACES
        self.f_s = K * stretch + B_C * (self.xd_s - self.v_o)

    def carry(self):
        """Advance the undamped object exactly under the forces held."""
        force = self.f_s.sum()
        self.x_o += H * self.v_o + H * H / 2 / M_O * force
        self.v_o += H / M_O * force


def one_step_delay(a, u):
    """Eq. 4."""
    a.carry()
    new = RATIO * u - a.f_s / B_W
    a.x_s = a.x_s + H * (a.share * new + (1.0 - a.share) * a.xd_s)
    a.xd_s = new
    a.touch()


def one_frame_late(a, u):
    """Eq. 14 with its sign corrected."""
    a.touch()
    a.x_s, a.xd_s = a.x_s + H * a.xd_s, RATIO * u - a.f_s / B_W
    a.carry()


def unwrapped(a, u):
    """App. C Eq. 4."""
    a.carry()
    g = H * a.share
    x_p = a.x_s + (H - g) * a.xd_s
    push = np.sqrt(2 * B_W) * u - K * (x_p - a.x_o - PLACES) + B_C * a.v_o
    a.xd_s = push / (B_W + B_C + g * K)
    a.x_s = x_p + g * a.xd_s
    a.touch()


def implicit(a, u):
    """Closed form of the midpoint rule (docs/theory.md 4.4)."""
    g = K * H / 2 + B_C
    rate, share = H / (2 * M_O), 1 + g / B_W
    push = (K * (a.x_s - a.x_o - PLACES) + g * RATIO * u) / share
    mean = (a.v_o + rate * push.sum()) / (1 + rate * a.b_o + rate * 2 * g / share)
    a.f_s = push - g * mean / share
    a.xd_s = RATIO * u - a.f_s / B_W
    a.x_s, a.x_o, a.v_o = a.x_s + H * a.xd_s, a.x_o + H * mean, 2 * mean - a.v_o


@pytest.mark.parametrize(
    ("law", "integrator", "b_o"),
    [
        *((one_step_delay, name, 0.0) for name in INTEGRATORS),
        *((unwrapped, name, 0.0) for name in INTEGRATORS),
        (one_frame_late, "backward_euler", 0.0),
        (implicit, "backward_euler", 0.0),
        (implicit, "backward_euler", 3.0),
    ],
)
def test_a_coupling_is_its_equation(law, integrator, b_o):
    server = two_users(law.__name__, integrator=integrator, object_damping=b_o)
    written = Written(MEAN_SHARE[integrator], b_o)
    for u in np.array(random_waves(1)):
        v = server.step(u.tolist())
        law(written, u)
        found = [server.x_o, server.xd_o, *server.x_s, *server.xd_s, *server.f_s, *v]
        expected = [written.x_o, written.v_o, *written.x_s, *written.xd_s, *written.f_s]
        expected += [*(u - RATIO * written.f_s)]
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-13)
        if law in (implicit, unwrapped):  # whose force is not late: power balances at the port
            np.testing.assert_allclose(
                np.multiply(server.f_s, server.xd_s), (u**2 - np.square(v)) / 2, atol=1e-12
            )


@pytest.mark.parametrize("coupling", NAMES)
@pytest.mark.parametrize("contact", ["bilateral", "grip"])
def test_pressed_steadily_a_wall_shows_its_stiffness_and_a_one_sided_one_lets_go(
    coupling, contact
):
    """In rest nothing moves: u = sqrt(b/2) F/b, and the avatar is F/K in, under every coupling."""
    k, force, gap_m = 400.0, 2.0, 0.01 if contact == "grip" else 0.0
    touch = {"contact_stiffness": k, "contact_damping": 5.0, "gap_m": gap_m}
    server = Users(
        ServerParams(coupling=coupling, environment="wall"),
        [ContactParams(contact=contact, **touch)],
        b=B_W,
    )
    server.join(0, -0.03)
    assert server.x_s[0] == pytest.approx(-0.03 - gap_m)
    assert server.offset[0] == pytest.approx(-gap_m)
    for _ in range(4000):
        server.step([force / (2 * B_W) ** 0.5])
    assert server.f_s[0] == pytest.approx(force)
    assert server.x_s[0] == pytest.approx(-0.03 + force / k)
    assert server.xd_s[0] == pytest.approx(0.0, abs=1e-12)
    assert server.v_s[0] == pytest.approx(-force / (2 * B_W) ** 0.5)
    assert server.touches(0)
    assert server.energies["potential"] == pytest.approx(0.5 * force**2 / k)
    assert server.x_o == 0.0
    if contact == "grip":
        for _ in range(60):
            server.step([-0.5])
        assert (server.f_s[0], server.v_s[0], server.touches(0)) == (0.0, -0.5, False)


def direct(users=1, *, contact="bilateral", environment="cube", dof=1, **values):
    contacts = [ContactParams(contact=contact, **values)] * users
    server = ServerParams(environment=environment)
    return Users(server, contacts, controller="direct", axes=dof)


def test_directly_coupled_the_avatar_stands_where_the_device_is_and_the_cube_moves():
    server = direct(2)
    server.join(0, 0.1)
    server.join(1, -0.1)
    forces = server.step([(0.102, 0.0), (-0.1, 0.05)])
    assert server.x_s == [0.102, -0.1]
    assert forces == pytest.approx([500.0 * 0.002, 10.0 * 0.05])
    assert server.x_o == 0.0
    server.step([(0.102, 0.0), (-0.1, 0.0)])
    assert server.x_o == pytest.approx(H**2 / 2 / 2.0 * 1.5)
    assert server.xd_o == pytest.approx(H / 2.0 * 1.5)
    assert server.f_s[0] == pytest.approx(500.0 * (0.002 - server.x_o) - 10.0 * server.xd_o)
    server.leave(0)
    server.leave(1)
    assert server.step([(0.102, 0.0), (-0.1, 0.0)]) == [0.0, 0.0]


@pytest.mark.parametrize("dof", [1, 3])
def test_a_direct_grip_starts_outside_and_keeps_its_offset(dof):
    server = direct(contact="grip", environment="wall", dof=dof)
    at = 0.0 if dof == 1 else np.zeros(3)
    inwards = 1.0 if dof == 1 else np.array([1.0, 0.0, 0.0])
    server.join(0, at)
    np.testing.assert_allclose(server.offset[0], -0.03 * inwards)
    for depth_m, force_n in ((0.0, 0.0), (0.002, 1.0), (-0.002, 0.0)):
        found = server.step([(at + depth_m * inwards, at)])[0]
        np.testing.assert_allclose(found, force_n * inwards, atol=1e-15)
    server.step([(at + 0.01 * inwards, at)])
    server.leave(0)
    assert server.dissipated == pytest.approx(0.5 * 500.0 * 0.01**2)
