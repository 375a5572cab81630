# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Frequency response of the anti-aliasing filter."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.design.filter_design import design

Complex: TypeAlias = NDArray[np.complex128]


def response(
    params: FilterParams, frequency_hz: Array, *, tick_s: float, rate_drop: int
) -> Complex:
    """Return the frequency response of an anti-aliasing filter at the tick rate.

    ``integrate_and_dump`` counts as the moving mean over M ticks whose last value in a frame the
    packet is.
    """
    omega = 2.0 * np.pi * np.asarray(frequency_hz, dtype=float) * tick_s
    if params.means:
        ages = np.arange(rate_drop)
        mean: Complex = np.exp(-1j * np.multiply.outer(omega, ages)).mean(axis=-1)
        return mean
    return sections_response(design(params, tick_s=tick_s), omega)


def sections_response(sos: Array, angle: Array) -> Complex:
    """Return the response of second-order sections ``(sections, 6)`` at angles [rad per tick].

    A factor (1 - 1/z) of a numerator or denominator is formed as such, so that it keeps its
    relative accuracy near rest.
    """
    delay = np.exp(-1j * np.asarray(angle, dtype=float))
    rest = 2j * np.sin(0.5 * angle) * np.exp(-0.5j * np.asarray(angle))  # 1 - 1/z
    found: Complex = np.ones_like(delay)
    for b0, b1, b2, a0, a1, a2 in sos:
        # c0 + c1 d + c2 d^2 = (c0 + c1 + c2) - (c1 + c2 (1 + d)) (1 - d)
        above = (b0 + b1 + b2) - (b1 + b2 * (1.0 + delay)) * rest
        below = (a0 + a1 + a2) - (a1 + a2 * (1.0 + delay)) * rest
        found = found * above / below
    return found
