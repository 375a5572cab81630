# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A playout conceals what comes late: no blow, no motion lost, a lag that follows the lateness."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmwvc_core.law.channel import pace
from pmwvc_core.law.channel.constants import FADE_S, HOLD_S, OUTAGE_S, REPORTED_S
from pmwvc_core.law.channel.playout import (
    Energies,
    PlayoutParams,
    add,
    play,
    resting_playout,
    waiting,
)

TICK_S, PACKET_S, WAVE = 0.001, 0.008, 0.3
FRAMES = 1500


def played(late_s, *, store_j=0.01, wave=lambda t: WAVE, frames=FRAMES):
    """Waves of a playout, tick by tick, whose packet k comes ``late_s(k)`` late (None: never), and
    by how much its time is behind that of the sender.
    """
    p = PlayoutParams(1.0, 1e-9, store_j)
    playout = resting_playout((0.0,), Energies())
    sums = np.concatenate(
        [[0.0], np.cumsum([wave(k * PACKET_S) * PACKET_S for k in range(frames)])]
    )
    paid = np.concatenate(
        [[0.0], np.cumsum([wave(k * PACKET_S) ** 2 * 0.5 * PACKET_S for k in range(frames)])]
    )
    due = sorted(
        (k * PACKET_S + late, k) for k in range(frames) if (late := late_s(k)) is not None
    )
    newest, waves, lags = 0, [], []
    for tick in range(round(frames * PACKET_S / TICK_S)):
        while due and due[0][0] <= tick * TICK_S + 1e-9:
            k = due.pop(0)[1] + 1
            if k > newest:
                lasted_s = (k - newest) * PACKET_S
                integral, energy_j = sums[k] - sums[newest], paid[k] - paid[newest]
                playout = add(playout, (integral,), energy_j, lasted_s, store_j)
                newest = k
        playout, (w,) = play(playout, TICK_S, p)
        waves.append(w)
        lags.append(tick * TICK_S - newest * PACKET_S + playout.pace.store_s)
        assert playout.moved.given_j <= playout.moved.received_j + store_j + 1e-12
    missing = sums[newest] - np.sum(waves) * TICK_S - waiting(playout)[0]
    assert missing == pytest.approx(0.0, abs=1e-12)
    return np.array(waves), np.array(lags) + TICK_S, playout


def test_lost_packets_are_bridged_as_far_as_the_hold_and_then_fade():
    waves, _, _ = played(lambda k: None if 500 <= k < 502 else 0.0)
    assert waves[4000:4050].min() > 0.9 * WAVE
    waves, _, _ = played(lambda k: None if 500 <= k < 540 else 0.0)
    hold, fade = (round(time_s / TICK_S) for time_s in (HOLD_S, FADE_S))
    assert waves[4000 + hold] > 0.99 * WAVE and waves[4000 + hold + 4 * fade] < 0.1 * WAVE
    assert np.abs(np.diff(waves[4000:4300])).max() < 0.03 * WAVE  # it fades


@given(rate=st.floats(18.0, 50.0), wave=st.floats(0.5, 3.0), lost=st.integers(1, 8))
@settings(max_examples=15, deadline=None)
def test_a_wave_that_the_store_cannot_carry_fades_so_that_it_lasts(rate, wave, lost):
    """Closed form: wave exp(-t wave^2/(4 E0)), whose energy is E0; then it rises within 30 ms."""
    waves, _, _ = played(
        lambda k: None if 50 <= k < 50 + lost else 0.0,
        store_j=wave**2 / (4.0 * rate), wave=lambda t: wave, frames=80,
    )  # fmt: skip
    faded = waves[400 : 400 + 8 * lost]
    expected = wave * np.exp(-rate * TICK_S * np.arange(1, 8 * lost + 1))
    assert faded == pytest.approx(expected, abs=0.04 * wave)
    slopes = np.abs(np.diff(waves[300 : 430 + 8 * lost])) / TICK_S
    assert slopes.max() < 1.1 * (rate + 1.0 / 0.03) * wave


def test_the_lag_follows_the_lateness_and_falls_with_it():
    rng = np.random.default_rng(3)
    jitter_s = np.where(np.arange(FRAMES) < 1000, rng.uniform(0.0, 0.007, FRAMES), 0.0)
    _, lags, _ = played(lambda k: jitter_s[k])
    assert lags[3200:8000].mean() == pytest.approx(0.0035 + 0.5 * TICK_S, abs=5e-4)
    assert abs(lags[-400:].mean()) < 1e-3


def test_a_burst_after_an_outage_makes_no_lag(monkeypatch):
    def outage(k):
        return 0.5 - 0.9 * (k - 500) * PACKET_S if 500 <= k < 560 else 0.0

    _, lags, _ = played(outage)
    assert lags[4700:].max() < 2.0 * PACKET_S
    monkeypatch.setattr(pace, "OUTAGE_S", np.inf)  # the control: no outage is seen
    _, lags, _ = played(outage)
    assert lags[4700:].max() > 5.0 * PACKET_S


def test_the_other_end_is_told_before_this_one_brakes_and_a_late_packet_does_neither():
    clock = pace.pace_arrive(pace.NEW, PACKET_S)
    told = braked = None
    for tick in range(200):
        clock, _, _ = pace.pace_step(clock, TICK_S)
        told = told or (clock.silent_s > REPORTED_S and tick)
        braked = braked or (clock.silent_s > OUTAGE_S and tick)
    assert told < braked
    assert braked * TICK_S == pytest.approx(PACKET_S + OUTAGE_S, abs=2 * TICK_S)
    clock = pace.pace_arrive(clock, PACKET_S)
    assert clock.silent_s <= REPORTED_S and not clock.silent_s > OUTAGE_S
