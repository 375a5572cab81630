# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From the times a signal was recorded at to the ticks it is played at.

1. Uneven sampling is made even (median interval) by monotone cubic interpolation. 2. A recording
faster than the ticks is low-passed forwards and backwards (no lag): Butterworth, order 8, -6 dB at
0.4 of the tick rate. 3. Monotone cubic interpolation (PCHIP: no overshoot, continuous slope) at
the ticks.
"""

import numpy as np

from pmwvc_core.numeric import Array

EVEN = 1e-3  # of an interval: time stamps this regular count as even
EDGE = 0.4  # of the tick rate: where the low-pass has -3 dB each way
ORDER = 8


def resample(values: Array, times: Array, *, tick_s: float) -> Array:
    """Return a signal ``(samples, columns)``, given with its rising times [s], at the ticks from
    its first sample to its last, ``(ticks, columns)``.
    """
    # Importing it takes over a second, which nodes without a recording need not wait for.
    from scipy import interpolate, signal

    times = times - times[0]
    interval = float(np.median(np.diff(times)))
    even = interval * np.arange(round(times[-1] / interval) + 1)
    if len(even) != len(times) or np.abs(even - times).max() > EVEN * interval:
        values, times = interpolate.PchipInterpolator(times, values)(even), even
    if interval < tick_s * (1.0 - 1e-9) and len(values) > 1:
        edge = 2.0 * EDGE * interval / tick_s  # as a ratio of half the recording's rate
        if edge < 1.0:
            sos = signal.butter(ORDER, edge, output="sos")
            padding = min(len(values) - 1, round(10.0 * tick_s / interval * ORDER))
            values = signal.sosfiltfilt(sos, values, axis=0, padlen=padding)
    ticks = tick_s * np.arange(int(times[-1] / tick_s * (1.0 + 1e-12)) + 1)
    return np.asarray(interpolate.PchipInterpolator(times, values)(np.minimum(ticks, times[-1])))


def fade(values: Array, *, fade_s: float, tick_s: float) -> Array:
    """Return the signal led in from zero and out to zero by half a cosine wave at either end.

    A signal shorter than twice ``fade_s`` is faded over its halves.
    """
    count = min(round(fade_s / tick_s), (len(values) - 1) // 2)
    if count < 1:
        return values
    rise = 0.5 - 0.5 * np.cos(np.pi * np.arange(count) / count)
    weight = np.ones(len(values))
    weight[:count] = rise
    weight[-count:] = rise[::-1]
    return values * weight[:, np.newaxis]
