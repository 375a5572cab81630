# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The brakes at device and avatar give back no more than was put in, whatever moves them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmwvc_core.master.brake import STALL_S, HandBrake
from pmwvc_core.numeric import dot, squared
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.server.avatar_brake import RETURN_S, AvatarBrake
from pmwvc_core.server.factory import make_ports
from pmwvc_core.server.port import WaveServer
from pmwvc_core.wave.brake_force import MEAN_S, RATIO
from pmwvc_core.wave.transform import WavePort

B, TICK_S, PERIOD_S = 25.0, 0.001, 0.008
K = B / STALL_S
ROUNDING = 1e-12
motions = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 10_000),
        "dof": st.integers(1, 6),
        "runs": st.sampled_from((0, 3)),
        "speed": st.sampled_from((1e-3, 0.05, 1.0)),
        "force": st.sampled_from((0.0, 0.3, 3.0)),
        "waits": st.lists(st.integers(1, 300), min_size=1, max_size=4),
    }
)


def course(motion, ticks=800):
    """Displacements, forces asked for and waits of a motion, tick by tick."""
    rng = np.random.default_rng(motion["seed"])
    shape = (motion["runs"], motion["dof"]) if motion["runs"] else (motion["dof"],)
    slow = np.cumsum(rng.normal(size=(ticks, *shape)), axis=0) / np.sqrt(ticks)
    moves = motion["speed"] * TICK_S * (slow + rng.normal(size=slow.shape))
    asked = motion["force"] * rng.normal(size=shape) + 0.1 * slow
    waiting = np.zeros(ticks, dtype=bool)
    at = 100
    for length in motion["waits"]:
        waiting[at : at + length] = True
        at += length + 60
    if shape == (1,):
        return moves[:, 0].tolist(), asked[:, 0].tolist(), waiting.tolist()
    return moves, asked, waiting.tolist()


@settings(max_examples=15)
@given(motion=motions)
def test_the_brake_of_a_device_gives_back_no_more_than_the_hand_put_in(motion):
    brake, x, f = HandBrake(B, tick_s=TICK_S), 0.0, 0.0
    work = sampled = damped = 0.0
    for dx, asked, waits in zip(*course(motion), strict=True):
        idle = brake.step(waits, x, f)
        own = brake.force(asked)
        if idle:
            assert np.all(own == 0.0)
        f = asked + own
        x = x + dx
        work = work + dot(own, dx + 0.0 * own)
        sampled = sampled + 0.5 * K * squared(dx)
        damped = damped + B * squared(dx) / TICK_S
        size = np.max(np.abs(sampled)) + np.max(np.abs(work))
        assert np.all(work + sampled >= -ROUNDING * size)
        assert np.all(work + damped >= -ROUNDING * size)


def test_a_last_force_that_is_held_gives_energy_out():
    """The control: what the brake would be without its spring."""
    work = 0.0
    for tick in range(500):
        dx = -1e-4 if tick > 100 else 0.0
        work += 1.5 * dx
    assert work < -0.05


def test_a_brake_holds_what_was_felt_and_nothing_in_free_motion():
    for felt in (0.0, 1.5):
        brake = HandBrake(B, tick_s=TICK_S)
        for _ in range(round(10 * MEAN_S / TICK_S)):
            brake.step(False, 0.0, felt)
        forces, x = [], 0.0
        for _ in range(200):
            brake.step(True, x, felt)
            forces.append(brake.force(0.0))
            x += 1e-4
        assert forces[-1] == pytest.approx(RATIO * felt, rel=1e-3)
        assert max(np.abs(np.diff([0.0, *forces]))) <= K * 1e-4 + 1e-12


def test_waits_in_a_row_do_not_make_a_brake_firmer():
    brake, f, x = HandBrake(B, tick_s=TICK_S), 1.5, 0.0
    for _ in range(500):
        brake.step(False, x, f)
    for tick in range(5000):
        brake.step(tick % 100 < 60, x, f)
        f = brake.force(0.0)
        x += 1e-4
        assert f <= RATIO * 1.5 + 1e-9


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), dof=st.integers(1, 6), runs=st.sampled_from((0, 3)))
def test_the_brake_of_an_avatar_turns_into_heat_what_its_port_loses(seed, dof, runs):
    rng = np.random.default_rng(seed)
    shape = (runs, dof) if runs else (dof,)
    brake, port = AvatarBrake(period_s=PERIOD_S), WavePort(B)
    for step in range(60):
        u, f = rng.normal(size=shape), rng.normal(size=shape)
        brake.waits = step % 9 in (4, 5)
        ratio = brake.ratio(port, u, f)
        if ratio is None:
            continue
        assert np.all(np.asarray(ratio) >= 1.0)
        inner = u / np.sqrt(ratio), rng.normal(size=shape)
        before = brake.heat_j
        v = brake.wave(u, inner, ratio)
        outside = 0.5 * PERIOD_S * (squared(u) - squared(v))
        inside = 0.5 * PERIOD_S * (squared(inner[0]) - squared(inner[1]))
        heat = brake.heat_j - before
        assert np.all(heat >= 0.0)
        assert np.allclose(outside, inside + heat, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("coupling", ["implicit", "one_step_delay", "unwrapped"])
def test_a_silent_avatar_holds_its_grip_and_returns_no_more_than_came(coupling):
    grips = {}
    for braked in (True, False):
        params = ServerParams(coupling=coupling, environment="wall")
        contact = ContactParams(contact="grip")
        server = WaveServer(params, make_ports(params, [contact], [B], dof=1, sides=[-1]))
        if braked:
            server.fit_brakes(PERIOD_S)
        server.join(0, -params.object_size_m / 2)
        taken, push = 0.0, 1.5 / math.sqrt(2.0 * B)
        for step in range(400):
            late = step - 250  # the wave is held for three steps, then it fades; the brake begins
            server.interrupt(0, late >= 5)
            u = push * min(math.exp(-(late - 3) * PERIOD_S / 0.03), 1.0)
            (v,) = server.step([u])
            taken += 0.5 * PERIOD_S * (u * u - v * v)
            assert taken >= -1e-12
            if step == 249:
                held = abs(server.f_s[0])
        grips[braked] = abs(server.f_s[0]) / held
        assert bool(server.accounts.get("avatar_brakes", 0.0) > 0.0) is braked
    assert held == pytest.approx(1.5, rel=0.05)
    assert grips[True] > 0.9  # after 1.2 s
    assert grips[False] < 0.01


def test_a_wave_that_pushes_meets_no_brake():
    brake, port = AvatarBrake(period_s=PERIOD_S), WavePort(B)
    for _ in range(50):
        brake.ratio(port, 0.2, 1.0)
    brake.waits = True
    ratios = [brake.ratio(port, 0.0, 1.0) for _ in range(6)]
    assert ratios[0] < 10.0 and ratios[-1] > 100.0  # a wait of one step stops no moving object
    assert brake.ratio(port, 1.0, 1.0) == 1.0
    brake.waits = False
    for _ in range(round(RETURN_S / PERIOD_S) + 1):
        ratio = brake.ratio(port, 0.0, 1.0)
    assert ratio is None
