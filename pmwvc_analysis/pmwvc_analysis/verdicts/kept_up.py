# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The oscillation that a loop keeps up, told from one that late packets set off again and again.

One that is kept up has one frequency all the time, and goes on while packets come in time; one
that is set off dies out there until the next late packet.
"""

import math
from collections.abc import Sequence

import numpy as np

from pmwvc_analysis.verdicts.oscillation import FADED, HALVED, Motion, Strength, beyond
from pmwvc_core.numeric import Array

NEAR, MOSTLY = 0.1, 0.6  # of a frequency; of a motion's power within that
CYCLES = 4  # in a third, by which one frequency is told from a few jolts
MOST = 0.7  # of it, where packets are late so often that nothing shows whether it goes on
PERIODS = 3  # in time, of a stretch that tells: the loop answers in the first


def kept_up(
    found: Strength,
    motion: Motion,
    duration_s: float,
    timely: Sequence[tuple[float, float]],
) -> bool:
    """Tell whether a motion beyond the band is one that a loop keeps up: most of it within a tenth
    of one frequency in each third of the judged span, ``CYCLES`` of it at least, no less than half
    as strong in the middle one as in the first, and no weaker by a tenth at the end of the
    ``timely`` stretches, from and until [s], in which packets come in time.
    """
    inside = motion.time_s >= max(0.5 * duration_s, motion.since_s)
    fast = beyond(motion.velocity, motion.period_s, motion.band_hz)[inside]
    if found.midway <= HALVED or len(fast) < 3 or not np.isfinite(fast).all() or not fast.any():
        return False
    whole = power_of(fast)
    strongest = int(np.argmax(whole))
    if strongest < 3 * CYCLES:
        return False
    thirds = [(power_of(third), strongest / 3.0) for third in np.array_split(fast, 3)]
    near = _near(whole, float(strongest))
    if min(near, *(_near(power, at) for power, at in thirds)) < MOSTLY:
        return False
    squares, time_s = np.sum(fast * fast, axis=-1), motion.time_s[inside]
    left = _left(squares, time_s, len(fast) * motion.period_s / strongest, timely)
    return near >= MOST if left is None else left >= FADED


def power_of(velocity: Array) -> Array:
    """Return the power spectrum of a velocity ``(ticks, dof)``, all axes together."""
    window = np.hanning(len(velocity)).reshape(-1, *[1] * (velocity.ndim - 1))
    found: Array = np.sum(np.abs(np.fft.rfft(velocity * window, axis=0)) ** 2, axis=-1)
    return found


def _near(power: Array, at: float) -> float:
    """Return how much of a power spectrum is near one of its bins."""
    bins = max(round(NEAR * at), 2)
    first = max(round(at) - bins, 0)
    total = float(power.sum())
    return float(power[first : round(at) + bins + 1].sum()) / total if total > 0.0 else 0.0


def _left(
    squares: Array, time_s: Array, strongest_s: float, timely: Sequence[tuple[float, float]]
) -> float | None:
    """Return the strength in the last period [s] of timely stretches over that in the second."""
    early, late = 0.0, 0.0
    for from_s, until_s in timely:
        periods = math.floor((until_s - from_s) / strongest_s)
        if periods < PERIODS:
            continue
        begins_s = (from_s + strongest_s, from_s + (periods - 1) * strongest_s)
        means = [squares[(time_s >= at) & (time_s < at + strongest_s)] for at in begins_s]
        if min(map(len, means)):
            early, late = early + float(means[0].mean()), late + float(means[1].mean())
    return math.sqrt(late / early) if early > 0.0 else None
