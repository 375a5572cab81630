# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's wave port does what its equations say, and survives what is no number."""

import math
import sys

import numpy as np
import pytest

from pmwvc_core.controllers.ends import make_master
from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.errors import ParameterError
from pmwvc_core.master.port import WaveMaster
from pmwvc_core.master.safety.limiter import SafetyLimiter
from pmwvc_core.params import (
    DeviceParams,
    FilterParams,
    MasterParams,
    OperatorParams,
    SafetyParams,
    TaskParams,
)
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.forces import Setting
from pmwvc_core.plant.operators import make_operator

M = 8
TICK_S = 0.001


def params(hold="zoh", b=25.0, **filtering):
    filtering = filtering or {"kind": "first_order", "pole_rad_s": 50.0}
    return MasterParams(
        impedance=b, rate_drop=M, tick_s=TICK_S, hold=hold, filter=FilterParams(**filtering)
    )


def tick(port, xd, x=0.0):
    f = port.step(x, xd)
    port.applied(f)
    return f


def test_the_published_example():
    """b = 25: F = 1 N at 0.1 m/s is u = 0.49497475, v = 0.21213203."""
    port = WaveMaster(params())
    port.receive(0.21213203435596428)
    assert tick(port, 0.1) == pytest.approx(1.0, rel=1e-12)
    assert port.u_m == pytest.approx(0.4949747468305833, rel=1e-12)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_without_safety_the_port_is_its_equations(hold):
    rng = np.random.default_rng(3)
    motion, packets = rng.normal(0.0, 0.2, (40, M)), rng.normal(0.0, 1.0, 40)
    port, b, p = WaveMaster(params(hold)), 25.0, math.exp(-50.0 * TICK_S)
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
            f = tick(port, xd)
            assert f == pytest.approx(b * xd - math.sqrt(2 * b) * v, rel=1e-12, abs=1e-14)
            assert (port.u_m, port.v_m) == pytest.approx((u, v), rel=1e-12, abs=1e-14)
            assert port.u_m_lp == pytest.approx(y, rel=1e-12, abs=1e-15)
            sums["u_m"] += u**2 / 2 * TICK_S
            sums["v_m"] += v**2 / 2 * TICK_S
        last = packet
    for name, energy in sums.items():
        assert getattr(port, f"energy_{name}") == pytest.approx(energy, rel=1e-12)
    assert port.deficit_j == 0.0


def test_silence_becomes_a_matched_damper_through_the_hold():
    port = WaveMaster(params("foh"))
    for _ in range(2):
        port.receive(-1.0)
        steady = [tick(port, 0.02) for _ in range(M)]
    port.silence()
    falling = [tick(port, 0.02) for _ in range(M)]
    assert falling[-1] == pytest.approx(25.0 * 0.02)
    changes = np.diff([steady[-1], *falling])
    np.testing.assert_allclose(changes, -math.sqrt(50.0) / M)
    port.receive(0.0)
    assert tick(port, -0.1) == pytest.approx(-2.5)


def test_a_shortened_wave_keeps_its_direction():
    port = WaveMaster(params())
    port.receive(np.array([0.1, -0.2, 0.3]))
    natural_f = port.step(np.zeros(3), np.array([0.2, 0.1, -0.1]))
    natural_u = port.u_m
    port.applied(0.5 * natural_f)
    share = port.u_m / natural_u
    np.testing.assert_allclose(share, share[0])
    assert 0.0 < share[0] < 1.0


def test_the_packets_position_is_that_of_the_device_also_before_the_first_tick():
    port = WaveMaster(params())
    port.measure(-0.03, 0.0)
    assert port.position() == -0.03
    tick(port, 0.0, x=-0.02)
    assert port.position() == -0.02


@pytest.mark.parametrize("broken", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("dof", [1, 2])
def test_a_motion_that_is_no_number_leaves_no_trace(broken, dof):
    port = WaveMaster(params())
    rest, bad = (0.0, broken) if dof == 1 else (np.zeros(2), np.array([0.0, broken]))
    port.receive(rest)
    tick(port, rest, x=rest + 0.5)
    assert np.all(tick(port, bad, x=bad) == 0.0)
    assert np.all(np.isfinite([port.send(), port.energy_u_m + rest]))
    assert np.ravel(port.position())[-1] == 0.5


def test_another_impedance_holds_from_the_next_tick_and_power_stays_right():
    port = WaveMaster(params())
    port.receive(0.4)
    tick(port, 0.1)
    before = port.u_m_lp
    port.configure(params(b=40.0))
    f = tick(port, 0.1)
    assert f == pytest.approx(40.0 * 0.1 - math.sqrt(80.0) * 0.4)
    assert f * 0.1 == pytest.approx((port.u_m**2 - port.v_m**2) / 2)
    assert port.u_m_lp != 0.0 and before != 0.0


def test_another_filter_or_hold_starts_from_zero():
    port = WaveMaster(params())
    port.receive(0.4)
    tick(port, 0.1)
    energy = port.energy_u_m
    port.configure(params("foh"))
    assert port.send() == 0.0
    assert tick(port, 0.1) == pytest.approx(2.5)  # v starts at zero: a damper
    assert port.energy_u_m > energy > 0.0


def test_a_batch_is_its_runs_side_by_side():
    rng = np.random.default_rng(8)
    impedances, poles = np.array([[5.0], [25.0], [80.0]]), np.array([[20.0], [50.0], [200.0]])
    batch = WaveMaster(params("foh", impedances, kind="first_order", pole_rad_s=poles))
    singles = [
        WaveMaster(params("foh", float(b), kind="first_order", pole_rad_s=float(pole)))
        for b, pole in zip(impedances[:, 0], poles[:, 0], strict=True)
    ]
    for _ in range(20):
        packets = rng.normal(0.0, 1.0, (3, 1))
        batch.receive(packets)
        for single, packet in zip(singles, packets[:, 0], strict=True):
            single.receive(float(packet))
        for _ in range(M):
            xd, share = rng.normal(0.0, 0.3, (3, 1)), rng.uniform(-1.0, 1.0, (3, 1))
            batch.applied(share * batch.step(xd, xd))
            for run, single in enumerate(singles):
                one = float(xd[run, 0])
                single.applied(float(share[run, 0]) * single.step(one, one))
        for name in ("u_m", "u_m_lp", "v_m", "f_m", "deficit_j", "energy_u_m", "energy_v_m"):
            together = np.ravel(getattr(batch, name))
            alone = [getattr(single, name) for single in singles]
            np.testing.assert_allclose(together, alone, rtol=1e-10, atol=1e-14)
        np.testing.assert_allclose(np.ravel(batch.send()), [s.send() for s in singles], rtol=1e-10)


def test_controllers_are_made_by_name():
    for name in LIBRARY:
        made = make_master(name, MasterParams())
        made.measure(0.1, 0.0)
        made.receive(0.0)
        made.applied(made.step(0.1, 0.0))
        assert (made.send(), made.position()) == (0.0, 0.1)
        made.silence()
        made.configure(MasterParams(impedance=30.0))
    with pytest.raises(ParameterError, match="controller = 'wave': must be one of pmwvc, direct"):
        make_master("wave", MasterParams())


def test_a_tick_of_hand_device_port_and_limits_keeps_no_memory():
    port, safety = (
        WaveMaster(params("foh")),
        SafetyLimiter(SafetyParams(), tick_s=TICK_S, packet_s=0.008),
    )
    device = SimulatedDevice(DeviceParams(), tick_s=TICK_S, dof=1)
    task = TaskParams(kind="carry", grip_s=0.0, move_s=0.0)
    hand = make_operator(OperatorParams(), task, Setting(-1, 0.0, 0.0, TICK_S, 1))

    def ticks(count):
        for number in range(count):
            x, xd = device.read()
            if number % M == 0:
                port.receive(-0.5 * port.send())
            f_h, f_m = hand.step(x, xd), port.step(x, xd)
            f = safety.step(f_m, x, xd, silence_s=0.0, coupled=True)
            port.applied(f)
            device.step(f_h, f)

    ticks(2000)
    before = sys.getallocatedblocks()
    ticks(2000)
    assert sys.getallocatedblocks() - before < 50
    assert all(type(value) is float for value in (port.u_m, port.u_m_lp, safety.f, device.x))
