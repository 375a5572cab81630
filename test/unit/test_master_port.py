# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's wave port does what its equations say, and survives what is no number; between the
rates: holds, means over frames, and the energy of a rate drop (App. A and B).
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.port_rig import Port
from support.strategies import TICK_S

from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.law.wave.filter_and_hold import filter_sample, filter_step
from pmwvc_core.made.waves import made_filter
from pmwvc_core.params import FilterParams, MasterParams
from reproduction import channel_energy

M = 8


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


@given(edge=st.floats(1.6, 3.14))
def test_a_wave_with_images_gives_out_energy_and_one_tick_later_takes_it_in(edge):
    for shift in (0, 1):
        found = channel_energy.aliasing_example(edge, shift=shift, ticks=20_000)
        for name in ("in_j", "out_j", "left_j"):
            assert found[name] == pytest.approx(found[f"closed_{name}"], abs=2e-8)
    assert found["closed_left_j"] > 0.0
    assert channel_energy.aliasing_example(edge, ticks=2)["closed_left_j"] == pytest.approx(
        -found["closed_left_j"]
    )


def test_the_published_numbers_are_twice_the_energies():
    edge, alpha = 2.0, 3.0
    found = channel_energy.aliasing_example(edge, height=alpha, tick_s=TICK_S)
    printed = -TICK_S * alpha**2 * (2 * edge - np.pi) / np.pi  # App. A Eq. 18
    assert 2.0 * found["left_j"] == pytest.approx(printed, rel=1e-4)


@pytest.mark.parametrize(("hz", "lowest_j"), [(5.0, -0.0095), (24.0, -0.046), (24.9, -0.40)])
def test_a_sine_below_half_the_packet_rate_still_gets_below_zero_on_the_way(hz, lowest_j):
    angles = 2.0 * np.pi * hz * TICK_S * np.arange(20_000)
    waves = [np.sin(angles + phase) for phase in np.linspace(0.0, np.pi, 91)]
    found = [channel_energy.rate_drop_energy(u, rate_drop=20, tick_s=TICK_S) for u in waves]
    assert min(one["left_j"].min() for one in found) == pytest.approx(lowest_j, rel=0.02)


@pytest.mark.parametrize(("ticks", "sent"), [(6, 6 / 8), (8, 1.0), (9, 1.0), (13, 1.0)])
def test_a_frame_is_divided_by_m_or_by_its_own_ticks_if_it_has_more(ticks, sent):
    params = FilterParams(kind="integrate_and_dump")
    s, p = made_filter(params, 1, 0.001, 8)
    for _ in range(2):  # the second frame knows nothing of the first
        for _ in range(ticks):
            s, _ = filter_step(s, (1.0,), p)
        s, wave = filter_sample(s, p)
        assert wave == pytest.approx((sent,), rel=1e-15)
        assert wave[0] ** 2 * max(8, ticks) <= ticks + 1e-12  # Cauchy-Schwarz
