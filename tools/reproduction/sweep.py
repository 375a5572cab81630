# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The admittance that a session with a given force shows: x/f = S_fx/S_ff (Welch), with the
coherence |S_fx|^2/(S_ff S_xx), 1 where the position follows from the force without noise.
"""

from typing import NamedTuple

import numpy as np
from scipy import signal

from pmwvc_core.numeric import Array, Complex
from pmwvc_core.scenario.scenario import User
from pmwvc_core.traces import UserTraces

STRETCH_S = 8.0  # of the force, for spectra
LEAST_STRETCHES = 3
LEAST_POWER = 1e-3  # of the largest power of the force, for a frequency to count
TRUSTED = 0.9  # coherence above which a value is worth comparing


class Admittance(NamedTuple):
    """Admittance of one user."""

    frequency_hz: Array  # (points,)
    admittance: Complex  # (points,) [m/N]
    coherence: Array  # (points,) 0..1


def measure(user: UserTraces, known: User) -> Admittance:
    """Return what the first axis of a user's traces shows, whose hand is a chirp."""
    acts = np.flatnonzero(user.f_h[:, 0])
    rows = slice(acts[0], acts[-1] + 1)
    force, position = user.f_h[rows, 0], user.x_m[rows, 0]
    length = int(min(STRETCH_S / user.tick_s, 2 * len(force) / (LEAST_STRETCHES + 1)))
    options = {"fs": 1.0 / user.tick_s, "nperseg": length, "detrend": "linear"}
    frequency, power = signal.welch(force, **options)
    _, cross = signal.csd(force, position, **options)
    _, coherence = signal.coherence(force, position, **options)
    low, high = sorted((known.operator.frequency_hz, known.operator.frequency_end_hz))
    asked = (power > LEAST_POWER * power.max()) & (frequency >= low) & (frequency <= high)
    asked[:2] = False  # what detrending took
    return Admittance(frequency[asked], cross[asked] / power[asked], coherence[asked])
