# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The couplings against their equations, written out step by step."""

import numpy as np
import pytest
from scipy.optimize import brentq
from support.law_rigs import Users

from pmwvc_core.law.server.contacts import advanced_contact
from pmwvc_core.law.server.springs import spring_answer
from pmwvc_core.made.server import contact_of
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import COUPLINGS as NAMES
from pmwvc_core.params.server import INTEGRATORS
from pmwvc_core.server.couplings import COUPLINGS

H, B_W, K, B_C, M_O = 0.008, 25.0, 500.0, 10.0, 2.0
RATIO = np.sqrt(2.0 / B_W)


def two_users(coupling, *, contact="bilateral", integrator="backward_euler", **server):
    contacts = ContactParams(contact=contact, contact_stiffness=K, contact_damping=B_C)
    params = ServerParams(coupling=coupling, integrator=integrator, object_mass=M_O, **server)
    made = Users(params, [contacts] * 2, b=B_W)
    made.join(0, -0.03)
    made.join(1, 0.03)
    return made


def random_waves(seed, steps=30):
    return np.random.default_rng(seed).normal(0.0, 0.3, (steps, 2)).tolist()


def follow(server, waves):
    """Return x_o, xd_o, x_s, xd_s, f_s, v_s per step."""
    rows = []
    for wave in waves:
        server.step(wave)
        rows.append([server.x_o, server.xd_o, *server.x_s, *server.xd_s, *server.f_s, *server.v_s])
    return np.array(rows)


def object_step(x, v, force):
    """Advance an undamped mass exactly under a held force."""
    return x + H * v + H * H / 2 / M_O * force, v + H / M_O * force


def test_every_coupling_a_parameter_can_name_exists():
    assert tuple(COUPLINGS.library) == NAMES


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_one_step_delay_is_equation_4(integrator):
    waves = random_waves(1)
    x_s, xd_s, f_s = np.array([-0.03, 0.03]), np.zeros(2), np.zeros(2)
    rest, x_o, v_o = x_s.copy(), 0.0, 0.0
    expected = []
    for u in np.array(waves):
        x_o, v_o = object_step(x_o, v_o, f_s.sum())
        new = RATIO * u - f_s / B_W
        mean = {"forward_euler": xd_s, "backward_euler": new, "trapezoid": (xd_s + new) / 2}
        x_s, xd_s = x_s + H * mean[integrator], new
        f_s = K * (x_s - x_o - rest) + B_C * (xd_s - v_o)
        expected.append([x_o, v_o, *x_s, *xd_s, *f_s, *(u - RATIO * f_s)])
    server = two_users("one_step_delay", integrator=integrator)
    np.testing.assert_allclose(follow(server, waves), expected, rtol=1e-10, atol=1e-13)


def test_one_frame_late_is_equation_14_with_its_sign_corrected():
    waves = random_waves(2)
    x_s, xd_s = np.array([-0.03, 0.03]), np.zeros(2)
    rest, x_o, v_o = x_s.copy(), 0.0, 0.0
    expected = []
    for u in np.array(waves):
        f_s = K * (x_s - x_o - rest) + B_C * (xd_s - v_o)
        x_s, xd_s = x_s + H * xd_s, RATIO * u - f_s / B_W
        x_o, v_o = object_step(x_o, v_o, f_s.sum())
        expected.append([x_o, v_o, *x_s, *xd_s, *f_s, *(u - RATIO * f_s)])
    server = two_users("one_frame_late")
    np.testing.assert_allclose(follow(server, waves), expected, rtol=1e-10, atol=1e-13)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_unwrapped_is_equation_4_of_the_black_box_paper(integrator):
    waves = random_waves(3)
    g = {"forward_euler": 0.0, "backward_euler": H, "trapezoid": H / 2}[integrator]
    x_s, xd_s, f_s = np.array([-0.03, 0.03]), np.zeros(2), np.zeros(2)
    rest, x_o, v_o = x_s.copy(), 0.0, 0.0
    expected = []
    for u in np.array(waves):
        x_o, v_o = object_step(x_o, v_o, f_s.sum())
        x_p = x_s + (H - g) * xd_s
        xd_s = (np.sqrt(2 * B_W) * u - K * (x_p - x_o - rest) + B_C * v_o) / (B_W + B_C + g * K)
        x_s = x_p + g * xd_s
        f_s = K * (x_s - x_o - rest) + B_C * (xd_s - v_o)
        expected.append([x_o, v_o, *x_s, *xd_s, *f_s, *(u - RATIO * f_s)])
    server = two_users("unwrapped", integrator=integrator)
    np.testing.assert_allclose(follow(server, waves), expected, rtol=1e-10, atol=1e-13)


@pytest.mark.parametrize("b_o", [0.0, 3.0])
def test_implicit_with_two_sided_contacts_is_its_closed_form(b_o):
    waves = random_waves(4)
    x_s, e = np.array([-0.03, 0.03]), np.zeros(2)
    x_o, v_o = 0.0, 0.0
    g = K * H / 2 + B_C
    a = g / B_W
    expected = []
    for u in np.array(waves):
        push = (K * e + g * RATIO * u) / (1 + a)
        mean = (v_o + H / (2 * M_O) * push.sum()) / (
            1 + H * b_o / (2 * M_O) + H / (2 * M_O) * 2 * g / (1 + a)
        )
        f_s = push - g * mean / (1 + a)
        xd_s = RATIO * u - f_s / B_W
        e, x_s = e + H * (xd_s - mean), x_s + H * xd_s
        x_o, v_o = x_o + H * mean, 2 * mean - v_o
        expected.append([x_o, v_o, *x_s, *xd_s, *f_s, *(u - RATIO * f_s)])
    server = two_users("implicit", object_damping=b_o)
    np.testing.assert_allclose(follow(server, waves), expected, rtol=1e-10, atol=1e-13)


def test_implicit_with_grips_solves_the_same_equations_as_a_bracketing_solver():
    waves = random_waves(5, steps=80)
    server = two_users("implicit", contact="grip")
    params = ContactParams(contact_stiffness=K, contact_damping=B_C)
    grips = [contact_of(params, side=side, size=0.06, axes=1) for side in (-1, 1)]
    v_o, pushed, free = 0.0, 0, 0
    for u in waves:

        def answers(mean, u=u, grips=grips):
            return [
                spring_answer(grip.springs[0], RATIO * w - mean, B_W, H, True, grip.law)
                for grip, w in zip(grips, u, strict=True)
            ]

        def missing(mean, v_o=v_o, answers=answers):
            return 2 * M_O / H * (mean - v_o) - sum(answer.force for answer in answers(mean))

        mean = brentq(missing, -5.0, 5.0, xtol=1e-15, rtol=1e-14)
        found = answers(mean)
        grips = [
            advanced_contact(grip, (answer.force,), (answer.rate,), H)[0]
            for grip, answer in zip(grips, found, strict=True)
        ]
        v_o = 2 * mean - v_o
        server.step(u)
        np.testing.assert_allclose(server.f_s, [answer.force for answer in found], atol=1e-8)
        assert server.xd_o == pytest.approx(v_o, abs=1e-10)
        touching = server.touches(0) + server.touches(1)
        pushed, free = pushed + touching, free + 2 - touching
    assert pushed > 10 and free > 10, "both states must occur for this to say anything"


@pytest.mark.parametrize("coupling", ["implicit", "unwrapped"])
def test_power_balances_at_the_port_where_the_force_is_not_late(coupling):
    server = two_users(coupling)
    for u in random_waves(6):
        v = server.step(u)
        for i in (0, 1):
            assert server.f_s[i] * server.xd_s[i] == pytest.approx((u[i] ** 2 - v[i] ** 2) / 2)


def test_power_does_not_balance_at_the_port_where_the_force_is_late():
    server = two_users("one_step_delay")
    gaps = []
    for u in random_waves(6):
        v = server.step(u)
        gaps.append(server.f_s[0] * server.xd_s[0] - (u[0] ** 2 - v[0] ** 2) / 2)
    assert np.abs(gaps).max() > 1e-3


@pytest.mark.parametrize("coupling", NAMES)
def test_all_couplings_agree_when_the_step_is_short(coupling):
    """Slow waves, 1 ms: what is left between the schemes is of the order of the step."""
    ends = []
    for name in ("implicit", coupling):
        server = two_users(name, contact="bilateral", period_s=0.001)
        for n in range(1000):
            push = 0.2 * np.sin(2 * np.pi * n / 1000)
            server.step([push, 0.5 * push])
        ends.append([server.x_o, *server.x_s])
    assert np.abs(ends[0]).max() > 0.01
    np.testing.assert_allclose(ends[1], ends[0], atol=2e-4)


@pytest.mark.parametrize("coupling", NAMES)
def test_mirrored_waves_give_mirrored_motion(coupling):
    one, other = two_users(coupling, contact="grip"), two_users(coupling, contact="grip")
    for left, right in random_waves(7, steps=100):
        one.step([left, right])
        other.step([-right, -left])
        assert one.x_o == pytest.approx(-other.x_o, abs=1e-12)
        assert one.f_s[0] == pytest.approx(-other.f_s[1], abs=1e-9)
