# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's wave port does what its equations say, and survives what is no number."""

import math

import numpy as np
import pytest
from support.law_rigs import Port

from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.params import FilterParams, MasterParams

M = 8
TICK_S = 0.001


def params(hold="zoh", b=25.0, **filtering):
    filtering = filtering or {"kind": "first_order", "pole_rad_s": 50.0}
    return MasterParams(
        impedance=b, rate_drop=M, tick_s=TICK_S, hold=hold, filter=FilterParams(**filtering)
    )


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_without_safety_the_port_is_its_equations(hold):
    rng = np.random.default_rng(3)
    motion, packets = rng.normal(0.0, 0.2, (40, M)), rng.normal(0.0, 1.0, 40)
    port, b, p = Port(params(hold)), 25.0, math.exp(-50.0 * TICK_S)
    y, last, sums = 0.0, 0.0, dict.fromkeys(("u_m", "u_tx", "v_rx", "v_m"), 0.0)
    for packet, velocities in zip(packets, motion, strict=True):
        assert port.send() == pytest.approx(y, rel=1e-12, abs=1e-15)
        sums["u_tx"] += y**2 / 2 * M * TICK_S
        port.receive(packet)
        sums["v_rx"] += packet**2 / 2 * M * TICK_S
        for j, xd in enumerate(velocities, start=1):
            v = packet if hold == "zoh" else last + (packet - last) * j / M
            u = math.sqrt(2 * b) * xd - v
            y = p * y + (1 - p) * u
            f = port.tick(xd)
            assert f == pytest.approx(b * xd - math.sqrt(2 * b) * v, rel=1e-12, abs=1e-14)
            assert (port.u_m, port.v_m) == pytest.approx((u, v), rel=1e-12, abs=1e-14)
            assert port.u_m_lp == pytest.approx(y, rel=1e-12, abs=1e-15)
            sums["u_m"] += u**2 / 2 * TICK_S
            sums["v_m"] += v**2 / 2 * TICK_S
        last = packet
    for name, energy in sums.items():
        assert port.energies[name] == pytest.approx(energy, rel=1e-12)
    assert port.s.deficit_j == 0.0


def test_silence_becomes_a_matched_damper_through_the_hold():
    port = Port(params("foh"))
    for _ in range(2):
        port.receive(-1.0)
        steady = [port.tick(0.02) for _ in range(M)]
    port.silence()
    falling = [port.tick(0.02) for _ in range(M)]
    assert falling[-1] == pytest.approx(25.0 * 0.02)
    changes = np.diff([steady[-1], *falling])
    np.testing.assert_allclose(changes, -math.sqrt(50.0) / M)
    port.receive(0.0)
    assert port.tick(-0.1) == pytest.approx(-2.5)


def test_the_packets_position_is_that_of_the_device_also_before_the_first_tick():
    port = Port(params())
    port.measure(-0.03, 0.0)
    assert port.x == -0.03
    port.tick(0.0, x=-0.02)
    port.send()
    assert port.sent.position == (-0.02,)


@pytest.mark.parametrize("broken", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("dof", [1, 2])
def test_a_motion_that_is_no_number_leaves_no_trace(broken, dof):
    port = Port(params(), axes=dof)
    rest, bad = (0.0, broken) if dof == 1 else (np.zeros(2), np.array([0.0, broken]))
    port.receive(rest)
    port.tick(rest, x=rest + 0.5)
    assert np.all(port.tick(bad, x=bad) == 0.0)
    assert np.all(np.isfinite([port.send(), port.energies["u_m"] + rest]))
    assert np.ravel(port.x)[-1] == 0.5


@pytest.mark.parametrize("controller", LIBRARY)
@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_a_port_at_rest_sends_nothing_and_pushes_nothing(controller, channel):
    port = Port(MasterParams(), controller=controller, channel=channel)
    port.measure(0.1, 0.0)
    port.silence()
    assert port.tick(0.0, x=0.1) == 0.0
    assert (port.send(), port.sent.position) == (0.0, (0.1,))
