# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The brakes at device and avatar give back no more than was put in, whatever moves them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag
from support.law_rigs import Users, loose_avatar

from pmwvc_core.law.channel.constants import STALL_S
from pmwvc_core.law.safety.brakes import (
    MEAN_S,
    RATIO,
    SETTLE_S,
    brake_stored_j,
    braked,
    hand_braked,
    loose_brake,
    unbraked,
)
from pmwvc_core.law.server.server_port import Came, environment_step
from pmwvc_core.law.vectors import dot, plus, scaled, squared
from pmwvc_core.law.wave.wave import damper, free_velocity, impedance, rooted
from pmwvc_core.made.user import groups_of
from pmwvc_core.made.waves import made_impedance
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.wave.impedance import MatrixImpedance

B, TICK_S, PERIOD_S = 25.0, 0.001, 0.008
K = B / STALL_S
ROUNDING = 1e-12
motions = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 10_000),
        "dof": st.integers(1, 6),
        "speed": st.sampled_from((1e-3, 0.05, 1.0)),
        "force": st.sampled_from((0.0, 0.3, 3.0)),
        "waits": st.lists(st.integers(1, 300), min_size=1, max_size=4),
    }
)


class Hand:
    """The brake at a device."""

    def __init__(self, axes=1):
        self.s, self.k = loose_brake((0.0,) * axes), K

    def step(self, waits, way, last, f):
        """Go one tick on; return the brake's force beside one that is asked for."""
        self.s, given = hand_braked(self.s, waits, way, last, f, TICK_S, self.k)
        return given


def course(motion, ticks=800):
    """Displacements, forces asked for and waits of a motion, tick by tick."""
    rng = np.random.default_rng(motion["seed"])
    shape = (motion["dof"],)
    slow = np.cumsum(rng.normal(size=(ticks, *shape)), axis=0) / np.sqrt(ticks)
    moves = motion["speed"] * TICK_S * (slow + rng.normal(size=slow.shape))
    asked = motion["force"] * rng.normal(size=shape) + 0.1 * slow
    waiting = np.zeros(ticks, dtype=bool)
    at = 100
    for length in motion["waits"]:
        waiting[at : at + length] = True
        at += length + 60
    return zip(
        map(tuple, moves.tolist()), map(tuple, asked.tolist()), waiting.tolist(), strict=True
    )


@settings(max_examples=20)
@given(motion=motions)
def test_the_brake_of_a_device_gives_back_no_more_than_the_hand_put_in(motion):
    nothing = (0.0,) * motion["dof"]
    brake, way, f = Hand(motion["dof"]), nothing, nothing
    work = sampled = damped = size = 0.0
    for dx, asked, waits in course(motion):
        own = brake.step(waits, way, f, asked)
        assert brake_stored_j(brake.s, brake.k) <= work + sampled + ROUNDING * size
        assert brake.s.largest.left > 0.0 or own == nothing
        f, way = plus(asked, own), dx
        work += dot(own, dx)
        sampled += 0.5 * K * squared(dx)
        damped += B * squared(dx) / TICK_S
        size = max(size, abs(sampled) + abs(work))
        assert work + sampled >= -ROUNDING * size
        assert work + damped >= -ROUNDING * size


def test_a_brake_holds_what_was_felt_and_nothing_in_free_motion():
    for felt in (0.0, 1.5):
        brake = Hand()
        for _ in range(round(10 * MEAN_S / TICK_S)):
            brake.step(False, (0.0,), (felt,), (0.0,))
        forces = [brake.step(True, (1e-4,), (felt,), (0.0,))[0] for _ in range(200)]
        assert forces[-1] == pytest.approx(RATIO * felt, rel=1e-3)
        assert max(np.abs(np.diff([0.0, *forces]))) <= K * 1e-4 + 1e-12


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000), dof=st.integers(1, 6))
def test_the_brake_of_an_avatar_turns_into_heat_what_its_port_loses(seed, dof):
    """It is the damper (N - 1) b, whatever comes back. Six axes have two, each behind a matrix."""
    rng, b, groups = np.random.default_rng(seed), impedance(B), groups_of(dof)
    if dof == 6:
        roots = rng.normal(size=(2, 3, 3))
        both = block_diag(*(10.0 * np.eye(3) + roots @ roots.swapaxes(1, 2)))
        b = made_impedance(MatrixImpedance(*np.linalg.eigh(both)))
    brake = loose_avatar(dof)
    for step in range(60):
        u, f, back = (tuple(rng.normal(size=dof).tolist()) for _ in range(3))
        waits = step % 9 in (4, 5)
        brake, inner, given = braked(brake, b, u, f, waits, PERIOD_S, groups)
        n = np.array(brake.n)
        assert min(n) >= 1.0
        velocity = scaled(free_velocity(inner, plus(given, back)), 0.5)
        before = brake.heat_j
        brake, own, v = unbraked(brake, inner, u, given, back, PERIOD_S, groups)
        for found, part in zip(own[:4], b[:4], strict=True):
            np.testing.assert_allclose(found, part, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(plus(u, v), rooted(b, velocity), atol=1e-12)
        outside = 0.5 * PERIOD_S * (squared(u) - squared(v))
        inside = 0.5 * PERIOD_S * (squared(given) - squared(back))
        heat = brake.heat_j - before
        assert heat == pytest.approx(
            PERIOD_S * np.dot((n - 1.0) * damper(b, velocity), velocity), rel=1e-9, abs=1e-15
        )
        assert outside == pytest.approx(inside + heat, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("coupling", ["implicit", "one_step_delay", "unwrapped"])
def test_a_silent_avatar_holds_its_grip_and_returns_no_more_than_came(coupling):
    grips = {}
    for channel in ("strict", "plain"):
        params = ServerParams(coupling=coupling, environment="wall")
        server = Users(params, [ContactParams(contact="grip")], b=B, channel=channel)
        server.join(0, -params.object_size_m / 2)
        taken, push = 0.0, 1.5 / math.sqrt(2.0 * B)
        for step in range(400):
            late = step - 250  # the wave is held for three steps, then it fades; the brake begins
            u = push * min(math.exp(-(late - 3) * PERIOD_S / 0.03), 1.0)
            came = Came((u,), (0.0,), late >= 5, 0.0, ())
            server.s = environment_step(server.p, server.s, (came,))
            taken += 0.5 * PERIOD_S * (u * u - server.v_s[0] ** 2)
            assert taken >= -1e-12
            if step == 249:
                held = abs(server.f_s[0])
        grips[channel] = abs(server.f_s[0]) / held
        assert (server.energies.get("avatar_brakes", 0.0) > 0.0) is (channel == "strict")
        assert held == pytest.approx(1.5, rel=0.05)
    assert grips["strict"] > 0.9  # after 1.2 s
    assert grips["plain"] < 0.01


def test_a_wave_that_pushes_meets_no_brake():
    brake, b = loose_avatar(1), impedance(B)

    def ratio(u, waits):
        nonlocal brake
        brake, *_ = braked(brake, b, (u,), (1.0,), waits, PERIOD_S, groups_of(1))
        return brake.n[0]

    for _ in range(50):
        assert ratio(0.2, False) == 1.0
    ratios = [ratio(0.0, True) for _ in range(6)]
    assert ratios[0] < 10.0 and ratios[-1] > 100.0  # a wait of one step stops no moving object
    assert ratio(1.0, True) == 1.0
    for _ in range(round(SETTLE_S / PERIOD_S) + 1):
        last = ratio(0.0, False)
    assert last == 1.0
