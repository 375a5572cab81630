# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Gain and delay of a filter with the rate drop behind it, warnings about its aliasing, and the
passivity of a wave's two branches behind a velocity filter.

A rate drop folds the spectrum: the frequencies theta + 2 pi j / M of the fast signal fall onto one
another. With H the filter at the tick rate, the packets of energy M T_c sum |u_tx|^2 carry at most

    g^2 = max over theta of sum_{j=0}^{M-1} |H(theta + 2 pi j / M)|^2

times the energy T_c sum |u|^2 that went into the filter. Passive over infinite time means g^2 <=
1; a filter divided by g always is. It does not bound the energy in between.

With a velocity filter (App. D) a low-pass branch goes to the environment and a share s of a
high-pass branch is fed back at once: v = R H_LP u + s H_HP u, with R the reflection of the
environment; passive means |R| <= 1.

====================  ============================================================================
in phase              |H_LP + s H_HP|^2 <= 1: R = 1. App. D Eq. 14; necessary, not sufficient
any environment       |H_LP| + s |H_HP| <= 1 at all frequencies: any R(z), since R may turn the
                      first term into the direction of the second; then sum u^2 - v^2 >= 0 at every
                      tick, as all of it is causal
switching             any passive thing at all (a contact that opens, a rate drop): it may move
                      the energy of one frequency to another, where it meets the high branch
====================  ============================================================================

Equations: docs/theory.md 2.6, 2.7, 7.4, 7.5, 7.6, 8.6, 11.6.
"""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array, Complex
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.filter_design import design, half_power_hz, sections_response

GRID = 65536  # frequencies looked at before the largest one is refined
TOLERANCE = 1e-9  # of an amplitude: what rounding may add to 1
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


def minimum_between(
    function: Callable[[float], float], low: float, high: float, *, within: float = 1e-9
) -> tuple[float, float]:
    """Return place and value of the minimum of a function with one minimum between ``low`` and
    ``high`` (of several one of them), by golden section, located ``within`` so much.
    """
    while high - low > within:
        step = GOLDEN * (high - low)
        if function(high - step) <= function(low + step):
            high = low + step
        else:
            low = high - step
    return 0.5 * (low + high), function(0.5 * (low + high))


def margins(
    low: Complex, high: Complex, frequency_hz: Array, *, share: float = 0.5
) -> dict[str, Any]:
    """Return ``in_phase`` |H_LP + s H_HP|^2 and ``any_environment`` |H_LP| + s |H_HP|, with the
    ``frequency_hz`` given ``(points,)``: frequency responses, ``high`` zero for a channel without
    that branch. Of each, ``.._margin`` is 1 less the largest value (negative: not met), and
    ``.._worst_hz`` where that is.
    """
    curves = {
        "in_phase": np.abs(low + share * high) ** 2,
        "any_environment": np.abs(low) + share * np.abs(high),
    }
    found: dict[str, Any] = {"frequency_hz": frequency_hz, **curves}
    for name, curve in curves.items():
        worst = int(np.argmax(curve))
        found[f"{name}_margin"] = 1.0 - float(curve[worst])
        found[f"{name}_worst_hz"] = float(frequency_hz[worst])
    return found


def switching_gain(low: Array, fed_back: Array) -> float:
    """Return how much longer the returning wave can be than the outgoing one, whatever reflects,
    from l = |H_LP| and the diagonal D of s |H_HP| at the images that a rate drop folds onto one
    another ``(points, images)``.

    For every x, |R l.x + D x|^2 <= (1 + c)|l.x|^2 + (1 + 1/c)|D x|^2 for all c > 0, so that

        gain^2 = min over c of max over frequency of eig[(1 + c) l l^T + (1 + 1/c) D^2].

    It is reached without a rate drop; with one it may be too large. At least it is sqrt(1 + s^2):
    s H_HP = s at high and |H_LP| = 1 at low frequency, so no such pair is passive against
    everything.
    """
    size = low.shape[-1]
    outer = low[:, :, np.newaxis] * low[:, np.newaxis, :]
    squares = fed_back[:, :, np.newaxis] ** 2 * np.eye(size)

    def worst(log_c: float) -> float:
        c = np.exp(log_c)
        matrices = (1.0 + c) * outer + (1.0 + 1.0 / c) * squares
        return float(np.linalg.eigvalsh(matrices)[:, -1].max())

    return float(np.sqrt(minimum_between(worst, -14.0, 14.0, within=1e-5)[1]))
