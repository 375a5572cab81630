# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Butterworth filters in closed form: least order, poles, second-order sections.

The analogue prototype of order n has its poles on the unit circle of the left half-plane,

    s_i = exp(j pi (2 i + n + 1)/(2 n)),        i = 0 ... n - 1;

low-pass: w_c s_i, no zeros; high-pass: w_c / s_i and n zeros at rest. Bilinear transform:
z = (2/T + s)/(2/T - s), which puts the zeros at z = -1 (low-pass) or z = 1 (high-pass). Each
section has unit gain in its pass band; the least damped one comes last. These are the designs of
``scipy.signal.buttord`` and ``butter`` (tested against them), whose import takes seconds.

Equations: docs/theory.md 2.3, 2.4.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array


def least_order(pass_hz: float, pass_db: float, stop_hz: float, stop_db: float) -> int:
    """Return the least order of an analogue filter, low-pass or high-pass, with both losses."""
    ratio = (10.0 ** (0.1 * stop_db) - 1.0) / (10.0 ** (0.1 * pass_db) - 1.0)
    span = stop_hz / pass_hz if stop_hz > pass_hz else pass_hz / stop_hz
    return math.ceil(math.log10(ratio) / (2.0 * math.log10(span)))


def analogue_poles(order: int, cutoff_rad_s: float, side: str) -> NDArray[np.complex128]:
    """Return the poles [rad/s] with positive imaginary part, best damped first; of an odd order
    the real one is among them.
    """
    angle = np.pi * (2.0 * np.arange(order) + order + 1.0) / (2.0 * order)
    unit = np.exp(1j * angle[: (order + 1) // 2])[::-1]
    if order % 2:
        unit[0] = -1.0
    return np.asarray(cutoff_rad_s * unit if side == "low" else cutoff_rad_s / unit.conj())


def bilinear_sections(order: int, cutoff_rad_s: float, tick_s: float, side: str = "low") -> Array:
    """Return ``b0 b1 b2 1 a1 a2`` per section of the filter by the bilinear transform, from order
    and -3 dB frequency of the analogue one; ``side`` (``low`` or ``high``) is what passes.
    """
    poles = 0.5 * tick_s * analogue_poles(order, cutoff_rad_s, side)
    zero = -1.0 if side == "low" else 1.0
    return _sections((1.0 + poles) / (1.0 - poles), order, zero=zero)


def matched_sections(order: int, cutoff_rad_s: float, tick_s: float) -> Array:
    """Return the low-pass filter with the poles exp(s T), without zeros."""
    poles = analogue_poles(order, cutoff_rad_s, "low")
    return _sections(np.exp(tick_s * poles), order, zero=None)


def _sections(poles: NDArray[np.complex128], order: int, *, zero: float | None) -> Array:
    """Return sections with these poles, all zeros at one place, and unit gain opposite to it."""
    found = []
    for number, pole in enumerate(poles):
        if order % 2 and number == 0:
            below = np.array([1.0, -pole.real, 0.0])
            above = np.array([1.0, 0.0 if zero is None else -zero, 0.0])
        else:
            below = np.array([1.0, -2.0 * pole.real, abs(pole) ** 2])
            above = np.array([1.0, 0.0, 0.0] if zero is None else [1.0, -2.0 * zero, 1.0])
        signs = np.ones(3) if zero != 1.0 else np.array([1.0, -1.0, 1.0])
        found.append(np.concatenate([above * (signs @ below) / (signs @ above), below]))
    return np.array(found)
