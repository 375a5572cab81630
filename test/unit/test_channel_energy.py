# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy of rate drop and holds, as the reproduction of App. A and B tells it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.strategies import TICK_S, rate_drops, signals

from pmwvc_core.law.wave.filter_and_hold import Hold, hold, load
from reproduction import channel_energy


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


def test_without_images_the_rate_drop_is_lossless_in_the_end():
    half = np.pi / 2
    found = channel_energy.aliasing_example(half)
    assert found["left_j"] == pytest.approx(0.0, abs=1e-9)
    assert found["closed_left_j"] == pytest.approx(0.0, abs=1e-12)


@given(rate_drop=rate_drops)
def test_a_spike_at_the_sampling_instant_leaves_m_times_as_large(rate_drop):
    spike = np.zeros(3 * rate_drop)
    spike[rate_drop] = 1.0
    found = channel_energy.rate_drop_energy(spike, rate_drop=rate_drop, tick_s=TICK_S)
    assert found["left_j"][-1] == pytest.approx(-(rate_drop - 1) * TICK_S / 2)
    beside = np.roll(spike, 1)
    if rate_drop > 1:
        found = channel_energy.rate_drop_energy(beside, rate_drop=rate_drop, tick_s=TICK_S)
        assert found["left_j"].min() == 0.0


@pytest.mark.parametrize(("hz", "lowest_j"), [(5.0, -0.0095), (24.0, -0.046), (24.9, -0.40)])
def test_a_sine_below_half_the_packet_rate_still_gets_below_zero_on_the_way(hz, lowest_j):
    angles = 2.0 * np.pi * hz * TICK_S * np.arange(20_000)
    waves = [np.sin(angles + phase) for phase in np.linspace(0.0, np.pi, 91)]
    found = [channel_energy.rate_drop_energy(u, rate_drop=20, tick_s=TICK_S) for u in waves]
    assert min(one["left_j"].min() for one in found) == pytest.approx(lowest_j, rel=0.02)


@given(packets=signals(longest=20), rate_drop=rate_drops, kind=st.sampled_from(["zoh", "foh"]))
def test_the_hold_is_the_one_that_runs(packets, rate_drop, kind):
    s, energy, ramp = Hold((0.0,), (0.0,), (0.0,), 0), 0.0, rate_drop if kind == "foh" else 1
    for packet in packets:
        s = load(s, (float(packet),))
        for _ in range(rate_drop):
            s, (wave,) = hold(s, ramp)
            energy += wave**2 * TICK_S / 2
    found = channel_energy.hold_energy(packets, rate_drop=rate_drop, tick_s=TICK_S, hold=kind)
    assert found["out_j"][-1] == pytest.approx(energy, rel=1e-9, abs=1e-15)
    if kind == "zoh":
        np.testing.assert_allclose(found["left_j"], 0.0, atol=1e-9 * (1 + energy))
