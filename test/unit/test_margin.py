# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The margin of a playout: up with waits, down where it is not used, no dips as delays creep."""

import numpy as np
import pytest

from pmwvc_core.wave.margin import BRAKED_S, FADE_S, SLACK_S, WINDOW_S, Margin
from pmwvc_core.wave.playout import Playout

TICK_S, PACKET_S, WAVE = 1e-3, 8e-3, 0.2
AMPLE = 3.0  # of the energy that the wave needs


def played(delay_s, duration_s, energy=AMPLE, playout=None):
    """Waves of a playout fed with a constant one, tick by tick, and its time at hand after each.

    Parameters
    ----------
    delay_s
        Delay of the packet sent at a time [s].
    """
    playout = playout or Playout(most_repaid=1.0)
    sent_s = np.arange(0.0, duration_s, PACKET_S)
    comes = np.maximum.accumulate(np.round((sent_s + [delay_s(s) for s in sent_s]) / TICK_S, 6))
    waves, at_hand_s, due = [], [], 0
    for tick in range(round(duration_s / TICK_S)):
        while due < len(comes) and comes[due] <= tick:
            playout.add(WAVE * PACKET_S, energy * 0.5 * WAVE**2 * PACKET_S, PACKET_S)
            due += 1
        waves.append(playout.step(TICK_S))
        at_hand_s.append(float(playout.at_hand_s))
    return np.array(waves), np.array(at_hand_s), playout


def creeping(time_s):
    """A delay that grows by 9 ms a second from 1 s on, as that of a satellite."""
    return 0.02 + 9e-3 * max(time_s - 1.0, 0.0)


def test_a_delay_that_creeps_makes_no_dips_once_two_waits_are_past():
    waves, at_hand_s, playout = played(creeping, 5.0)
    assert np.count_nonzero(waves[1000:1300] < 0.65 * WAVE) <= 2
    assert waves[1300:].min() > 0.65 * WAVE
    assert at_hand_s[-1] < 0.011 and playout.margin.time_s <= 1.1 * TICK_S


def test_without_a_margin_every_tick_of_delay_is_a_dip(monkeypatch):
    """The control."""
    monkeypatch.setattr(Margin, "rate", lambda self, h: 1.0)
    monkeypatch.setattr(Margin, "faster", 1.0)
    waves, *_ = played(creeping, 5.0)
    assert np.count_nonzero(waves[1300:] < 0.2 * WAVE) > 20


def held_back(time_s):
    """The first packets, over 50 ms, come at once: a link that was only then established."""
    return 0.02 + max(0.05 - time_s, 0.0)


def test_what_the_first_packets_bring_at_once_makes_no_lag_and_no_motion_is_lost():
    for energy in (1.0, AMPLE):
        waves, at_hand_s, playout = played(held_back, 2.0, energy)
        assert at_hand_s[70:].max() < PACKET_S + 2 * TICK_S + SLACK_S
        came = np.ceil((2.0 - 0.02) / PACKET_S)
        given = waves.sum() * TICK_S
        assert given + float(playout.waiting) == pytest.approx(came * WAVE * PACKET_S)
    assert abs(float(playout.undelivered)) < 1e-9  # made up: the energy was ample


def test_a_playout_that_takes_the_first_burst_as_regular_keeps_its_lag(monkeypatch):
    """The control."""
    monkeypatch.setattr("pmwvc_core.wave.playout.RETURN_S", 0.0)
    _, at_hand_s, _ = played(held_back, 2.0, energy=1.0)
    assert at_hand_s[1000:].min() > 0.035


def uneven(until_s):
    rng = np.random.default_rng(4)
    return lambda time_s: 0.02 + (0.024 * rng.random() if time_s < until_s else 0.0)


def test_a_margin_is_there_soon_and_gone_within_seconds_of_the_last_use():
    waves, at_hand_s, playout = played(uneven(5.0), 20.0)
    assert np.count_nonzero(waves[2000:5000] == 0.0) <= 5  # it is there
    assert at_hand_s[4500:5000].min() < 8e-3 and at_hand_s[4500:5000].max() > 16e-3
    before = PACKET_S + playout.margin.time_s + SLACK_S
    assert at_hand_s[-1000:].max() <= before + 1e-3
    assert playout.margin.time_s <= 0.024 * np.exp(-(15.0 - 2.0 * WINDOW_S) / FADE_S)
    assert waves.max() <= 1.3 * WAVE * (1.0 + 1e-9)


def test_without_energy_to_spare_nothing_is_caught_up():
    _, at_hand_s, playout = played(uneven(5.0), 20.0, energy=1.0)
    assert at_hand_s[-1000:].max() > 0.02
    assert playout.short
    assert playout.given_j <= playout.received_j


def test_a_margin_in_use_does_not_fade():
    """One packet a second is late; after two waits nothing is waited for any more."""

    def now_and_then(time_s):
        number = round(time_s / PACKET_S)
        return 0.02 + (0.0 if number % 125 != 60 else 0.006 if number < 125 else 0.011)

    waves, *_ = played(now_and_then, 30.0)
    assert np.count_nonzero(waves[:2000] < 0.5 * WAVE) > 5
    assert waves[2000:].min() > 0.65 * WAVE


def after_a_wait():
    """Waves from the end of a wait of 10 ms on; packets come every 8 ms again."""
    waves, *_ = played(lambda time_s: 0.02 if time_s < 0.5 else 0.03, 1.0)
    waited = np.flatnonzero(waves[100:] < 0.1 * WAVE) + 100
    assert 9 <= len(waited) <= 11
    return waves[waited[-1] + 1 :]


def test_after_a_wait_the_wave_returns_slowly():
    waves = after_a_wait()
    assert waves[0] == pytest.approx(0.5 * WAVE, rel=0.05)
    assert np.diff(waves).min() >= -1e-12
    assert waves[10] < 0.8 * WAVE and waves[100] > 0.99 * WAVE


def test_a_wave_that_is_back_at_once_is_whole(monkeypatch):
    """The control."""
    monkeypatch.setattr("pmwvc_core.wave.margin.RESTART_S", 0.0)
    assert after_a_wait()[0] > 0.95 * WAVE


def test_a_short_wait_brakes_nobody_and_a_longer_one_does():
    playout = Playout(most_repaid=1.0)
    playout.add(WAVE * PACKET_S, WAVE**2 * PACKET_S, PACKET_S)
    dry = []
    for _ in range(30):
        playout.step(TICK_S)
        dry.append(playout.dry)
    assert dry.index(True) == int((PACKET_S + BRAKED_S) / TICK_S)
