# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Gaps of any length in a wave that varies slowly: no blow in them, at their end, or while what
was lost is made up.
"""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from support.receiving import Playing

from pmwvc_core.law.channel.constants import TANK_J

TICK_S, TICKS, WAVE = 0.001, 8, 0.23  # 1.6 N at b = 25 N s/m
FRAME_S = TICKS * TICK_S
FELT = 0.25 * WAVE  # the change within a tick


def largest_change(seed, store_j, frames=400):
    """Return the largest change of the wave within a tick, with gaps of up to 16 packets."""
    lends = {"store_j": store_j, "keep_j": TANK_J - store_j}
    playout, waves = Playing(steps=TICKS, most_repaid=0.5, **lends), []
    rng = np.random.default_rng(seed)
    lost, waited, integral, paid_j = 0, 0, 0.0, 0.0
    for frame in range(frames):
        wave = WAVE * (1.0 + 0.3 * np.sin(np.pi * frame * FRAME_S))
        integral, paid_j = integral + wave * FRAME_S, paid_j + 0.5 * wave**2 * FRAME_S
        waited += 1
        if lost == 0 and frame > 30 and rng.random() < 0.06:
            lost = int(rng.integers(1, 17))
        if lost:
            lost -= 1
        else:
            playout.add(integral, paid_j, waited * FRAME_S)
            waited, integral, paid_j = 0, 0.0, 0.0
        waves += [playout.step(TICK_S) for _ in range(TICKS)]
        assert playout.given_j <= playout.received_j + store_j + 1e-12
    return float(np.abs(np.diff(waves[30 * TICKS :])).max())


@given(seed=st.integers(0, 2**32 - 1), store_j=st.sampled_from([TANK_J, 0.01]))
@settings(max_examples=40, deadline=None)
def test_no_gap_is_felt_as_a_blow(seed, store_j):
    assert largest_change(seed, store_j) < FELT


def test_with_nothing_to_lend_a_gap_is_a_blow():
    """The control."""
    assert all(largest_change(seed, 0.0) > FELT for seed in range(5))
