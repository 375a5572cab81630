# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The distance of a filter with the rate drop behind it from giving out energy.

Everything here holds over infinite time (Parseval); the balance at each instant may be lower.

**Filter and rate drop.** Packets carry at most g^2 times the energy of the waves they sample,
where g^2 is the largest value of the folded squared gain (:mod:`pmwvc_core.wave.aliasing`).

Two branches, one of them fed back (App. D): :mod:`pmwvc_core.wave.aliasing`.
"""

from typing import TypedDict

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.aliasing import worst_case_gain
from pmwvc_core.wave.filter_design import response

TOLERANCE = 1e-12  # of a squared gain: what rounding may add to 1


class FoldedGain(TypedDict):
    """Energy gain of filter and rate drop over frequency."""

    frequency_hz: Array  # (points,) from 0 to half the packet rate
    folded: Array  # (points,) packet energy per energy that went in
    gain: float  # g^2, the largest value over all frequencies
    passive: bool


def energy_gain(
    params: FilterParams, *, tick_s: float, rate_drop: int, points: int = 513
) -> FoldedGain:
    """Return how much energy packets carry per energy of the wave, over frequency and at worst.

    The folded gain sum_j |H(f + j / (M T_c))|^2 is that of a wave whose images all have the phase
    that adds up; the decimator itself (no filter) has M.
    """
    frame_s = rate_drop * tick_s
    frequency = np.linspace(0.0, 0.5 / frame_s, points)
    images = np.add.outer(frequency, np.arange(rate_drop) / frame_s)
    values = response(params, images, tick_s=tick_s, rate_drop=rate_drop)
    gain = float(worst_case_gain(params, tick_s=tick_s, rate_drop=rate_drop))
    return {
        "frequency_hz": frequency,
        "folded": np.sum(np.abs(values) ** 2, axis=-1),
        "gain": gain,
        "passive": gain <= 1.0 + TOLERANCE,
    }
