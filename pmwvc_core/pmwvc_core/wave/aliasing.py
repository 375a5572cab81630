# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Gain and delay of a filter with the rate drop behind it, and warnings about its aliasing.

A rate drop folds the spectrum: the frequencies theta + 2 pi j / M of the fast signal fall onto one
another. With H the filter at the tick rate, the packets of energy M T_c sum |u_tx|^2 carry at most

    g^2 = max over theta of sum_{j=0}^{M-1} |H(theta + 2 pi j / M)|^2

times the energy T_c sum |u|^2 that went into the filter. Passive over infinite time means g^2 <=
1; a filter divided by g always is. It does not bound the energy in between.

Equations: docs/theory.md 2.6, 2.7, 11.6.
"""

import functools
import math
from collections.abc import Callable

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.filter_design import design, half_power_hz, sections_response

GRID = 65536  # frequencies looked at before the largest one is refined
FINER = 5  # times that an interval is divided into 64
TOLERANCE = 1e-9  # of an amplitude: what rounding may add to 1


@functools.lru_cache(maxsize=1024)
def worst_case_gain(params: FilterParams, *, tick_s: float, rate_drop: int) -> float:
    """Return the largest possible ratio g^2 of packet energy to filter-input energy.

    First order: M (1-p)/(1+p) (1+p^M)/(1-p^M), at rest. ``integrate_and_dump``: 1 by the Cauchy-
    Schwarz inequality. ``none``: M, a spike at the sampling instant.
    """
    if not params.is_on:
        return float(rate_drop)
    if params.means:
        return 1.0
    sos = design(params, tick_s=tick_s)
    images = 2.0 * np.pi * np.arange(rate_drop) / rate_drop

    def folded(theta: Array) -> Array:
        values = sections_response(sos, np.add.outer(theta, images))
        return np.asarray((values.real**2 + values.imag**2).sum(axis=-1))

    # the fold is even and has period 2 pi / M
    return peak(folded, np.linspace(0.0, np.pi / rate_drop, max(GRID // rate_drop, 64)))[1]


def peak(function: Callable[[Array], Array], points: Array) -> tuple[float, float]:
    """Return place and value of the maximum of a function: at the best of ascending points, then
    between its neighbours.
    """
    for _ in range(FINER):
        best = int(np.argmax(function(points)))
        points = np.linspace(points[max(best - 1, 0)], points[min(best + 1, len(points) - 1)], 65)
    values = function(points)
    return float(points[np.argmax(values)]), float(values.max())


def delay_of(params: FilterParams, *, tick_s: float, rate_drop: int) -> float:
    """Return the group delay at low frequency [s] of the filter alone.

    It is counted from a tick's wave to the output after the same tick: p/(1-p) ticks for the first
    order, (M-1)/2 for ``integrate_and_dump``, none for ``none``. Packets, holds and network come
    on top.
    """
    if params.means:
        return 0.5 * (rate_drop - 1) * tick_s
    if not params.is_on:
        return 0.0
    sos, age = design(params, tick_s=tick_s), np.arange(3)
    above, below = (c @ age / c.sum(axis=1) for c in (sos[:, :3], sos[:, 3:]))  # mean ages
    return float((above - below).sum()) * tick_s


def warnings_of(params: FilterParams, *, tick_s: float, rate_drop: int) -> list[str]:
    """Return, in words, why aliasing must be expected (an empty list where it need not be).

    The packets can represent frequencies up to half their rate; a filter whose -3 dB frequency
    lies above lets more through, and what is folded down can be energy that no hand has given.
    """
    half_rate_hz, edge_hz = 0.5 / (rate_drop * tick_s), half_power_hz(params, tick_s=tick_s)
    if rate_drop == 1 or params.means or edge_hz <= half_rate_hz:
        return []
    edge = "none: there is no filter" if math.isinf(edge_hz) else f"{edge_hz:.4g} Hz (-3 dB)"
    gain = worst_case_gain(params, tick_s=tick_s, rate_drop=rate_drop)
    return [
        f"the edge of the anti-aliasing filter ({edge}) is above half the packet rate "
        f"({half_rate_hz:.4g} Hz): in the worst case packets carry {gain:.4g} times the "
        f"energy that went in"
    ]
