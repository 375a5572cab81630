# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The high-pass filter that feeds the outgoing wave back (App. D), for any anti-aliasing filter:
its design, and its effect on velocity and lag. Its passivity: :mod:`.aliasing`.

Unless the parameters give it, the filter follows from H_LP, the response of the anti-aliasing one:

* order 1, H_HP = (z - 1)/(z - alpha): the alpha that makes |H_LP + s H_HP|^2 as flat as can be,
  min over alpha of max over 512 frequencies of | |H_LP + s H_HP|^2 - 1 |, with alpha below the
  pole of H_LP (App. D section 4). Published is 0.92913; this gives 0.9274, and the error function
  behind it is not stated.
* order n >= 2, Butterworth: the lowest cut-off with |H_LP| + s |H_HP| <= 1 everywhere. Near rest
  1 - |H_LP| rises with the power 2m of the frequency (m the order of H_LP; 1 for
  ``integrate_and_dump``) and |H_HP| with the power n, so that n >= 2m is what it takes: no filter
  of first order has this margin (a little less than 2m may fail by less than rounding).
* complementary, H_1 and H_2 a Butterworth pair of order n, |H_1|^2 + |H_2|^2 = 1 (bilinear, so
  exactly that): any cut-off will do; it is half the packet rate, above which no packet can carry
  anything. Both branches go through their filter twice: H_LP = H_1^2 with the anti-aliasing filter
  between, H_HP = H_2^2.

Equations: docs/theory.md 7.8, 7.9.
"""

import dataclasses
import functools
import math
from typing import Any

import numpy as np

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Array, Complex
from pmwvc_core.params import MasterParams, VelocityFilterParams
from pmwvc_core.wave.aliasing import TOLERANCE, peak
from pmwvc_core.wave.filter_design import (
    bilinear_sections,
    half_power_hz,
    response,
    sections_response,
    warped_rad_s,
)

POINTS_IN_PHASE = 512  # frequencies of App. D section 4
POINTS = 8192  # of a search, half of them near rest
CUTOFF_RATIO = 1.001  # of a cut-off: what may lie between two of them
HIGHEST = 0.49  # of the tick rate, of a cut-off that is given
HIGHEST_DESIGNED = 0.25  # above that hardly anything would be filtered
SLOW = 1e-6  # angle [rad per tick] at which a lag is read


def passing(params: MasterParams, side: str) -> Array:
    """Return the sections ``(sections, 6)`` of H_HP (``high``; of ``complementary`` one of the two
    H_2) or H_1 (``low``); ParameterError where no such filter exists.
    """
    own, tick_s = chosen(params).velocity_filter, params.tick_s
    if own.alpha is not None:
        return np.array([[1.0, -1.0, 0.0, 1.0, -own.alpha, 0.0]])
    assert own.cutoff_hz is not None  # chosen
    return bilinear_sections(own.order, warped_rad_s(own.cutoff_hz, tick_s), tick_s, side)


@functools.lru_cache(maxsize=1024)
def chosen(params: MasterParams) -> MasterParams:
    """Return parameters with ``alpha`` or ``cutoff_hz`` given; ParameterError where no such filter
    exists. Kept, as a node asks before and when it changes over.
    """
    own, low, tick_s = params.velocity_filter, params.filter, params.tick_s
    found: dict[str, Any]
    if own.cutoff_hz is not None and own.cutoff_hz * tick_s > HIGHEST:
        raise ParameterError(
            f"velocity_filter.cutoff_hz = {own.cutoff_hz}: must be <= "
            f"{HIGHEST / tick_s:g} Hz at this tick"
        )
    if own.cutoff_hz is not None or own.alpha is not None:
        return params
    if own.splits:
        found = {"cutoff_hz": min(0.5 / params.rate_drop, HIGHEST_DESIGNED) / tick_s}
    elif not low.is_on:
        raise ParameterError(
            "filter.kind = none: an anti-aliasing filter is what a velocity filter is designed "
            "for; take one, or give velocity_filter.cutoff_hz"
        )
    elif own.order > 1:
        rising = (1.0 + np.arange(POINTS // 2)) / (POINTS // 2)
        angle = np.pi * np.concatenate([np.geomspace(1e-6, 1.0, POINTS // 2), rising])
        found = {"cutoff_hz": _lowest_cutoff(own, np.abs(_low(params, angle)), angle, tick_s)}
    else:
        angle = np.pi * np.arange(POINTS_IN_PHASE) / POINTS_IN_PHASE
        edge = half_power_hz(low, tick_s=tick_s)
        below = 1.0 if math.isinf(edge) else math.exp(-2.0 * math.pi * edge * tick_s)
        values = _low(params, angle)
        found = {"alpha": flattest_alpha(values, angle, share=own.share, below=below)}
    return dataclasses.replace(params, velocity_filter=dataclasses.replace(own, **found))


def _low(params: MasterParams, angle: Array) -> Complex:
    """Return H_LP at angles ``(points,)`` [rad per tick]."""
    tick_s, frequency_hz = params.tick_s, angle / (2.0 * np.pi * params.tick_s)
    return response(params.filter, frequency_hz, tick_s=tick_s, rate_drop=params.rate_drop)


def flattest_alpha(low: Complex, angle: Array, *, share: float = 0.5, below: float) -> float:
    """Return the alpha of (z - 1)/(z - alpha), 0 < alpha < ``below``, that makes
    |H_LP + s H_HP|^2 deviate least from 1 over angles ``(points,)`` [rad per tick].
    """
    z = np.exp(1j * angle)

    def fit(alpha: Array) -> Array:
        high = (z - 1.0) / (z - alpha[:, np.newaxis])
        return np.asarray(-np.abs(np.abs(low + share * high) ** 2 - 1.0).max(axis=1))

    return peak(fit, np.linspace(0.0, below, 97)[1:-1])[0]


def _lowest_cutoff(own: VelocityFilterParams, low: Array, angle: Array, tick_s: float) -> float:
    """Return the lowest cut-off [Hz] with the any-environment margin, by bisection."""
    warped = np.tan(0.5 * np.minimum(angle, np.pi * (1.0 - 1e-9)))

    def excess(cutoff_hz: float) -> float:
        ratio = math.tan(math.pi * cutoff_hz * tick_s) / warped
        high = 1.0 / np.sqrt(1.0 + ratio ** (2 * own.order))
        return float((low + own.share * high).max()) - 1.0

    few, many = 1e-8 / tick_s, HIGHEST_DESIGNED / tick_s / CUTOFF_RATIO
    if excess(many) > TOLERANCE:
        raise ParameterError(
            f"velocity_filter.share = {own.share}: no high-pass filter of order {own.order} "
            "leaves |H_LP| + share |H_HP| <= 1 with this anti-aliasing filter; take a higher "
            "order (twice that of the anti-aliasing filter), a smaller share, or kind = "
            "complementary, or give cutoff_hz"
        )
    while many / few > 1.0 + 1e-9:
        middle = math.sqrt(few * many)
        few, many = (middle, many) if excess(middle) > 0.1 * TOLERANCE else (few, middle)
    return many * CUTOFF_RATIO


def slow_lags(params: MasterParams) -> tuple[float, float]:
    """Return what the filter adds to the lag of slow motion once around, pressing on a wall and
    with nothing touched [s].

    Near rest H_HP is tau p, p the derivative in time (order 1; zero for higher orders). A wall
    returns v = -(1 - lag p) u + s tau p u: longer by s tau. Free: shorter by as much. The
    equivalent form takes 2 s b tau off the felt mass, which is b lag/2.
    """
    if not params.velocity_filter.is_on:
        return 0.0, 0.0
    own, tick_s = params.velocity_filter, params.tick_s
    angle = np.array([SLOW])
    fed = sections_response(passing(params, "high"), angle)[0]
    if own.splits:
        passed = sections_response(passing(params, "low"), angle)[0] ** 2
        longer = -float(passed.imag) / SLOW * tick_s
        return longer, longer
    answered = float(own.share) * float(fed.imag) / SLOW * tick_s
    return (0.0, -4.0 * answered) if own.in_force else (answered, -answered)
