# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy of rate drop, holds and computational delay, against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.strategies import TICK_S, rate_drops, signals

from pmwvc_core.law.wave.filter_and_hold import Hold, hold, load
from reproduction import channel_energy


def sine_deficit(
    frequency_hz: float,
    *,
    rate_drop: int,
    tick_s: float = 1e-3,
    amplitude: float = 1.0,
    phases: int = 360,
):
    """Return how far below zero a decimator gets on the way, at the worst phase of a sine.

    The sine is sent without a filter. Below half the packet rate nothing is aliased and the energy
    balances in the end, yet not at every instant: the packets' |u|^2 swings at the distance of 2 f
    from the packet rate, and a packet counts for a whole frame at its start.

    Returns
    -------
    dict
        ``minimum_j``, ``time_s`` and ``phase_rad`` of the minimum, over two swings.
    """
    packet_hz = 1.0 / (rate_drop * tick_s)
    beat_hz = abs(2.0 * frequency_hz - packet_hz * round(2.0 * frequency_hz / packet_hz))
    slowest_hz = max(min(beat_hz, 2.0 * frequency_hz), 0.01)
    ticks = int(np.ceil(2.0 / slowest_hz / tick_s)) + 2 * rate_drop
    time_s = np.arange(ticks) * tick_s
    best = {"minimum_j": 0.0, "time_s": 0.0, "phase_rad": 0.0}
    for phase in np.pi * np.arange(phases) / phases:  # |u|^2 has period pi
        wave = amplitude * np.sin(2.0 * np.pi * frequency_hz * time_s + phase)
        left = channel_energy.rate_drop_energy(wave, rate_drop=rate_drop, tick_s=tick_s)["left_j"]
        lowest = int(np.argmin(left))
        if left[lowest] < best["minimum_j"]:
            best = {
                "minimum_j": float(left[lowest]),
                "time_s": float(time_s[lowest]),
                "phase_rad": float(phase),
            }
    return best


def first_order_hold_left(packets, *, rate_drop: int, tick_s: float):
    """Return the closed form of what the delayed hold has left at each frame end [J]."""
    packets, ratio = np.asarray(packets, dtype=float), rate_drop
    steps = np.cumsum(np.diff(packets, prepend=0.0) ** 2)
    scale = tick_s * (ratio - 1) / (12.0 * ratio)
    return scale * ((ratio + 1) * steps + 3.0 * ratio * packets**2)


def delay_energy(force, *, impedance: float, period_s: float):
    """Return what decoding with the force of the previous step does to the energy (App. C Eq. 12).

    With xd(n) = sqrt(2/b) u(n) - F(n-1)/b the port takes in (u^2 - v^2)/2 = F xd + d(n), where
    d(n) = [F(n) F(n-1) - F(n)^2]/b is less than the environment gets. Summed, with F(-1) = 0,

        dE = (T/b) sum [F(n) F(n-1) - F(n)^2] = -(T/2b) [sum (F(n) - F(n-1))^2 + F(N)^2] <= 0.

    Parameters
    ----------
    force
        F(n) ``(step,)`` [N].

    Returns
    -------
    dict
        ``power_w`` d(n) of each step, ``energy_j`` its running sum, ``closed_j`` the closed form.
    """
    force = np.asarray(force, dtype=float)
    before = np.concatenate([[0.0], force[:-1]])
    power = (force * before - force**2) / impedance
    steps = np.cumsum((force - before) ** 2)
    return {
        "power_w": power,
        "energy_j": np.cumsum(power) * period_s,
        "closed_j": -0.5 * period_s / impedance * (steps + force**2),
    }


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


def test_the_example_is_for_waves_that_are_aliased():
    with pytest.raises(ValueError, match="between pi/2 and pi"):
        channel_energy.aliasing_example(1.0)


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


@pytest.mark.parametrize(
    ("frequency_hz", "lowest"), [(5.0, -0.0095), (24.0, -0.046), (24.9, -0.40)]
)
def test_a_sine_below_half_the_packet_rate_still_gets_below_zero_on_the_way(frequency_hz, lowest):
    found = sine_deficit(frequency_hz, rate_drop=20, phases=90)
    assert found["minimum_j"] == pytest.approx(lowest, rel=0.02)


def test_a_sine_that_swings_slowly_borrows_its_whole_swing():
    beat_hz = 50.0 - 2 * 24.9
    found = sine_deficit(24.9, rate_drop=20, phases=90)
    # |u|^2/2 of the packets swings by 1/4 at the beat; from crest to trough that is 1/(4 pi f)
    assert found["minimum_j"] == pytest.approx(-0.5 / (2 * np.pi * beat_hz), rel=0.02)


@given(packets=signals(longest=40), rate_drop=rate_drops)
def test_the_first_order_hold_keeps_its_closed_form(packets, rate_drop):
    found = channel_energy.hold_energy(packets, rate_drop=rate_drop, tick_s=TICK_S)
    closed = first_order_hold_left(packets, rate_drop=rate_drop, tick_s=TICK_S)
    scale = found["in_j"][-1] + 1e-12
    np.testing.assert_allclose(found["left_j"], closed, atol=1e-12 * scale)
    assert np.all(found["left_j"] >= -1e-12 * scale)


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


def test_a_hold_that_starts_elsewhere_gives_out_energy():
    start, ratio = 1.0, 8
    ramp = start * (1.0 - np.arange(1, ratio + 1) / ratio)  # to a packet of zero
    spent = np.sum(ramp**2) * TICK_S / 2
    assert spent == pytest.approx(start**2 * TICK_S * (ratio - 1) * (2 * ratio - 1) / (12 * ratio))


@given(force=signals(), impedance=st.floats(1.0, 100.0))
def test_decoding_with_the_old_force_always_gives_out_energy(force, impedance):
    found = delay_energy(force, impedance=impedance, period_s=0.008)
    scale = np.sum(force**2) / impedance * 0.008 + 1e-12
    np.testing.assert_allclose(found["energy_j"], found["closed_j"], atol=1e-10 * scale)
    assert np.all(found["energy_j"] <= 1e-10 * scale)


def test_the_delay_energy_is_what_port_and_environment_differ_by():
    rng = np.random.default_rng(2)
    b, period, u, force = 25.0, 0.008, rng.standard_normal(50), rng.standard_normal(50)
    before = np.concatenate([[0.0], force[:-1]])
    xd = np.sqrt(2 / b) * u - before / b
    v = u - np.sqrt(2 / b) * force
    port = np.cumsum((u**2 - v**2) / 2) * period
    found = delay_energy(force, impedance=b, period_s=period)
    np.testing.assert_allclose(
        port - np.cumsum(force * xd) * period, found["energy_j"], atol=1e-12
    )
