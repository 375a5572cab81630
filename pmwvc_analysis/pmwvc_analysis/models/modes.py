# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The frequency of a motion from an eigenvalue over a hyperperiod of N ticks.

An eigenvalue gives the phase of a motion once a hyperperiod, so its frequency up to multiples of
1/(N T_c). The motion within the hyperperiod decides which: y(k) lambda^(-k/N) has period
N, and its largest harmonic j gives (arg lambda + 2 pi j)/(2 pi N T_c).
"""

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array

CLEAR = 0.5  # of the strongest harmonic's power: what another may have at most


def frequency_hz(
    value: complex, vector: NDArray[np.complex128], rows: Array, tick_s: float
) -> float | None:
    """Return the frequency of a motion; None where nothing of it is seen or two are as strong.

    Parameters
    ----------
    value, vector
        Eigenvalue over the hyperperiod, and eigenvector.
    rows
        ``(signals, ticks, states)``: what is looked at, at every tick of the hyperperiod.
    """
    ticks = rows.shape[1]
    seen = rows @ vector  # (signals, ticks)
    sizes = np.abs(seen).max(axis=1, keepdims=True)
    if value == 0.0 or not sizes.any():
        return None
    angle = float(np.angle(value))
    fade = np.exp(-(np.log(np.abs(value)) + 1j * angle) * np.arange(ticks) / ticks)
    power = np.sum(np.abs(np.fft.fft(seen * fade, axis=1)) ** 2, axis=0)
    harmonics = np.fft.fftfreq(ticks, 1.0 / ticks)
    hertz = np.abs(angle + 2.0 * np.pi * harmonics) / (2.0 * np.pi * ticks * tick_s)
    best = int(np.argmax(power))
    others = np.abs(hertz - hertz[best]) > 1e-9 * (1.0 / tick_s)
    if np.any(power[others] > CLEAR * power[best]):
        return None
    return float(hertz[best])
