# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The effect of a velocity filter (App. D) on waves, velocity, lag and noise, over frequency.

Its design: :mod:`.velocity_filter_design`. Its passivity: :mod:`.branches`.

Equations: docs/theory.md 7.9.
"""

import numpy as np

from pmwvc_core.numeric import Array, Complex
from pmwvc_core.params import MasterParams
from pmwvc_core.wave.design.filter_design import response, sections_response
from pmwvc_core.wave.design.velocity_filter_design import chosen, sections_of

SLOW = 1e-6  # angle [rad per tick] at which a lag is read


def branches(params: MasterParams, frequency_hz: Array) -> tuple[Complex, Complex]:
    """Return the responses of the branch to the environment and back, and of that fed back (all
    of it, not the share), for parameters that :func:`chosen` has completed.
    """
    tick_s, own = params.tick_s, params.velocity_filter
    angle = 2.0 * np.pi * tick_s * np.asarray(frequency_hz, dtype=float)
    low = response(params.filter, frequency_hz, tick_s=tick_s, rate_drop=params.rate_drop)
    high = sections_response(sections_of(own, tick_s, "highpass"), angle)
    if not own.splits:
        return low, high
    pair = sections_response(sections_of(own, tick_s, "lowpass"), angle)
    return low * pair**2, high**2


def velocity_gain(params: MasterParams, frequency_hz: Array) -> Complex:
    """Return what is left of the velocity in the force, F_m/(b xd) while nothing comes back.

    Exact and complementary (1 - s H)/(1 + s H), equivalent 1 - 2 s H.
    """
    _, high = branches(params, frequency_hz)
    fed = params.velocity_filter.share * high
    if params.velocity_filter.in_force:
        return np.asarray(1.0 - 2.0 * fed)
    return np.asarray((1.0 - fed) / (1.0 + fed))


def slow_lags(params: MasterParams) -> tuple[float, float]:
    """Return what the filter adds to the lag of slow motion once around, pressing on a wall and
    with nothing touched [s].

    Near rest H_HP is tau p, p the derivative in time (order 1; zero for higher orders). A wall
    returns v = -(1 - lag p) u + s tau p u: longer by s tau. Free, v = (1 - lag p) u + s tau p u:
    shorter by as much. The equivalent form leaves the waves alone and takes 2 s b tau off the felt
    mass, which is b lag/2.
    """
    if not params.velocity_filter.is_on:
        return 0.0, 0.0
    own, tick_s = chosen(params).velocity_filter, params.tick_s
    angle = np.array([SLOW])
    fed = sections_response(sections_of(own, tick_s, "highpass"), angle)[0]
    if own.splits:
        passed = sections_response(sections_of(own, tick_s, "lowpass"), angle)[0] ** 2
        longer = -float(passed.imag) / SLOW * tick_s
        return longer, longer
    answered = float(own.share) * float(fed.imag) / SLOW * tick_s
    return (0.0, -4.0 * answered) if own.in_force else (answered, -answered)


def noise_gain(params: MasterParams) -> float:
    """Return the length of the noise that the difference of a rounded position makes in the
    force, beside that without a filter (rms; white rounding errors).
    """
    turn = np.arange(16384) / 16384
    power = 4.0 * np.sin(np.pi * turn) ** 2  # |1 - 1/z|^2, on average 2
    gain = velocity_gain(params, turn / params.tick_s)
    return float(np.sqrt(np.mean(np.abs(gain) ** 2 * power) / 2.0))
