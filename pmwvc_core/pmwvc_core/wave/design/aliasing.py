# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Gain and delay of a filter with the rate drop behind it, and warnings about its aliasing.

A rate drop folds the spectrum: the frequencies theta + 2 pi j / M of the fast signal fall onto one
another. With H the filter at the tick rate, the packets of energy M T_c sum |u_tx|^2 carry at most

    g^2 = max over theta of sum_{j=0}^{M-1} |H(theta + 2 pi j / M)|^2

times the energy T_c sum |u|^2 that went into the filter: the largest eigenvalue of "filter, then
drop" times its adjoint, which is a convolution at the packet rate. Passive over infinite time
means g^2 <= 1; a filter divided by g always is. It does not bound the energy in between.

Equations: docs/theory.md 2.6, 2.7, 11.6.
"""

import functools
import math
from collections.abc import Callable

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.design.filter_design import design, half_power_hz, sections_response

GRID = 65536  # frequencies looked at before the largest one is refined
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


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

    def folded(theta: Array | float) -> Array:
        values = sections_response(sos, np.add.outer(np.atleast_1d(theta), images))
        return np.asarray((values.real**2 + values.imag**2).sum(axis=-1))

    end = np.pi / rate_drop  # the fold is even and has period 2 pi / M
    theta = np.linspace(0.0, end, max(GRID // rate_drop, 64))
    gains = folded(theta)
    peak = int(np.argmax(gains))
    around = float(theta[max(peak - 1, 0)]), float(theta[min(peak + 1, len(theta) - 1)])
    _, least = minimum_between(lambda t: -float(folded(t)[0]), *around, within=1e-9 * end)
    return float(max(gains[peak], -least))


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
    if rate_drop == 1 or params.means:
        return []
    half_rate_hz = 0.5 / (rate_drop * tick_s)
    edge_hz = half_power_hz(params, tick_s=tick_s)
    if edge_hz <= half_rate_hz:
        return []
    edge = "none: there is no filter" if math.isinf(edge_hz) else f"{edge_hz:.4g} Hz (-3 dB)"
    gain = worst_case_gain(params, tick_s=tick_s, rate_drop=rate_drop)
    return [
        f"the edge of the anti-aliasing filter ({edge}) is above half the packet rate "
        f"({half_rate_hz:.4g} Hz): in the worst case packets carry {gain:.4g} times the "
        f"energy that went in"
    ]


def minimum_between(
    function: Callable[[float], float], low: float, high: float, *, within: float = 1e-9
) -> tuple[float, float]:
    """Return place and value of the minimum of a function with one minimum between ``low`` and
    ``high`` (of several one of them), by golden section, located ``within`` so much.
    """
    step = GOLDEN * (high - low)
    left, right = high - step, low + step
    at_left, at_right = function(left), function(right)
    while high - low > within:
        if at_left <= at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = function(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = function(right)
        if not low < left < right < high:  # no floats in between
            break
    return (left, at_left) if at_left <= at_right else (right, at_right)
