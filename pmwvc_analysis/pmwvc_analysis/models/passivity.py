# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a filter, alone or with the rate drop behind it, is from giving out energy.

Everything here holds over infinite time (Parseval). What happens on the way is in
:mod:`pmwvc_analysis.models.channel_energy`.

**Filter and rate drop.** Packets carry at most g^2 times the energy of the waves they sample,
where g^2 is the largest value of the folded squared gain (:mod:`pmwvc_core.wave.aliasing`).

**Two branches** (App. D). A low-pass branch goes to the environment, half of a high-pass branch is
fed back: v = R H_LP u + H_HP u / 2, with R the reflection of the environment, |R| <= 1 where it is
passive. So |v| <= |u| for *every* passive environment if and only if

    |H_LP| + |H_HP| / 2 <= 1        at all frequencies,

since R may turn the first term into the direction of the second. App. D Eq. 14 is the case R = 1
(reflection in phase): |H_LP + H_HP/2|^2 <= 1, which is necessary, not sufficient.
"""

from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.aliasing import worst_case_gain
from pmwvc_core.wave.filter_design import design

Complex = NDArray[np.complex128]
TOLERANCE = 1e-12  # of a squared gain: what rounding may add to 1
PRINTED_LOW_POLE = 0.95  # H_LP = 0.05/(z - 0.95), App. D Eq. 15


class FoldedGain(TypedDict):
    """Energy gain of filter and rate drop over frequency."""

    frequency_hz: Array  # (points,) from 0 to half the packet rate
    folded: Array  # (points,) packet energy per energy that went in
    gain: float  # g^2, the largest value over all frequencies
    passive: bool


class Margins(TypedDict):
    """What is left of the two conditions on a pair of branches."""

    frequency_hz: Array  # (points,)
    in_phase: Array  # (points,) |H_LP + H_HP/2|^2, App. D Eq. 14
    any_environment: Array  # (points,) |H_LP| + |H_HP|/2
    in_phase_margin: float  # 1 less the largest value; negative: not met
    in_phase_worst_hz: float
    any_environment_margin: float
    any_environment_worst_hz: float


def response(
    params: FilterParams, frequency_hz: Array, *, tick_s: float, rate_drop: int
) -> Complex:
    """Return the frequency response of an anti-aliasing filter at the tick rate.

    ``integrate_and_dump`` counts as the moving mean over M ticks whose last value in a frame the
    packet is.
    """
    from scipy import signal

    omega = 2.0 * np.pi * np.asarray(frequency_hz, dtype=float) * tick_s
    if params.kind == "integrate_and_dump":
        ages = np.arange(rate_drop)
        mean: Complex = np.exp(-1j * np.multiply.outer(omega, ages)).mean(axis=-1)
        return mean
    _, values = signal.sosfreqz(design(params, tick_s=tick_s), np.atleast_1d(omega))
    found: Complex = values.reshape(omega.shape)
    return found


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


def margins(low: Complex, high: Complex, frequency_hz: Array) -> Margins:
    """Return both conditions on a low-pass branch and a high-pass branch fed back halved.

    Parameters
    ----------
    low, high
        Frequency responses ``(points,)``; ``high`` zero for a channel without that branch.
    frequency_hz
        Where they were taken ``(points,)``.
    """
    in_phase = np.abs(low + 0.5 * high) ** 2
    any_environment = np.abs(low) + 0.5 * np.abs(high)
    worst, worst_any = int(np.argmax(in_phase)), int(np.argmax(any_environment))
    return {
        "frequency_hz": frequency_hz,
        "in_phase": in_phase,
        "any_environment": any_environment,
        "in_phase_margin": 1.0 - float(in_phase[worst]),
        "in_phase_worst_hz": float(frequency_hz[worst]),
        "any_environment_margin": 1.0 - float(any_environment[worst_any]),
        "any_environment_worst_hz": float(frequency_hz[worst_any]),
    }


def printed_branches(
    alpha: float, *, low_pole: float = PRINTED_LOW_POLE, points: int = 512
) -> tuple[Array, Complex, Complex]:
    """Return angles [rad per tick] from 0 to below pi, H_LP and H_HP of App. D Eqs. 15 and 16.

    H_LP = (1 - p)/(z - p), H_HP = (z - 1)/(z - alpha).
    """
    angle = np.pi * np.arange(points) / points
    z = np.exp(1j * angle)
    return angle, (1.0 - low_pole) / (z - low_pole), (z - 1.0) / (z - alpha)


def best_alpha(*, low_pole: float = PRINTED_LOW_POLE, points: int = 512) -> float:
    """Return the alpha of App. D Eq. 16 with the flattest in-phase condition.

    It minimises max over frequency of | |H_LP + H_HP/2|^2 - 1 | for 0 < alpha < the low-pass pole,
    as the text says. The printed result is 0.92913; which error function that came from cannot be
    told.
    """
    from scipy import optimize

    def error(alpha: float) -> float:
        _, low, high = printed_branches(alpha, low_pole=low_pole, points=points)
        return float(np.max(np.abs(np.abs(low + 0.5 * high) ** 2 - 1.0)))

    grid = np.linspace(0.0, low_pole, 97)[1:-1]
    start = int(np.argmin([error(float(alpha)) for alpha in grid]))
    around = grid[max(start - 1, 0)], grid[min(start + 1, len(grid) - 1)]
    found = optimize.minimize_scalar(
        error, bounds=around, method="bounded", options={"xatol": 1e-9}
    )
    return float(found.x)
