# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows of a trace reduced: running sums of energy, numbers of a summary, stretches with a flag
set, intervals [s], the part above a frequency. An unknown number is None, never NaN.
"""

import math
from collections.abc import Iterable
from typing import Any, Literal

import numpy as np

from pmwvc_analysis.traces.thresholds import FINAL_S
from pmwvc_core.account import continued
from pmwvc_core.numeric import Array, Flags

HIGHEST = 0.45  # of the rate of a signal: a part above it is not known


def running(sums: Array) -> Array:
    """Return sums that only grow, going on where a user that left and came back began at zero."""
    return continued(sums, np.flatnonzero(np.diff(sums) < 0.0) + 1)


def sum_of(sums: Iterable[Array]) -> Array:
    """Return the sum of several energies over time; a plain zero of none."""
    return np.asarray(np.sum(list(sums), axis=0), dtype=float)


def number(value: Any) -> float | None:
    """Return a plain finite float, or None."""
    value = float(value)
    return value if math.isfinite(value) else None


def final(
    values: Array, time_s: Array, end_s: float, reduced: Any = np.mean
) -> float | list[float | None] | None:
    """Return the mean, or what else an axis is ``reduced`` to, of the 0.5 s before ``end_s``: a
    number for one axis, a list for several; None when there is nothing.
    """
    rows = values[(time_s >= end_s - FINAL_S - 1e-9) & (time_s <= end_s + 1e-9)]
    rows = rows if len(rows) else np.full((1, values.shape[-1]), np.nan)
    numbers = [number(value) for value in np.atleast_1d(reduced(rows, axis=0))]
    return numbers[0] if len(numbers) == 1 else numbers


def rms(values: Array) -> float | None:
    """Return the root mean square of vector lengths, rows that are not finite left out."""
    lengths = np.sum(np.atleast_2d(values) ** 2, axis=-1)
    lengths = lengths[np.isfinite(lengths)]
    return number(np.sqrt(lengths.mean())) if len(lengths) else None


def percentiles(values: Array, scale: float = 1.0) -> dict[str, float | None]:
    """Return ``p50``, ``p99`` and ``max`` of values times ``scale``."""
    values = values[np.isfinite(values)] * scale
    if not len(values):
        return dict.fromkeys(("p50", "p99", "max"))
    median, high = np.percentile(values, (50, 99))
    return {"p50": number(median), "p99": number(high), "max": number(values.max())}


def begins(flags: Flags) -> Flags:
    """Tell in which rows a flag is set that was not in the row before."""
    return np.asarray(flags & ~np.concatenate([[False], flags[:-1]]))


def spans(flags: Flags) -> list[slice]:
    """Return the rows of every stretch with a flag set."""
    edges = np.flatnonzero(np.diff(flags.astype(int), prepend=0, append=0)).tolist()
    return [slice(start, end) for start, end in zip(edges[::2], edges[1::2], strict=True)]


def runs(flags: Flags, time_s: Array, join_s: float) -> list[tuple[int, int]]:
    """Return first and last row of every stretch with a flag set; close ones are one, however far
    apart rows are.
    """
    rows = np.flatnonzero(flags)
    breaks = np.flatnonzero((np.diff(rows) > 1) & (np.diff(time_s[rows]) > join_s)) + 1
    return [(int(each[0]), int(each[-1])) for each in np.split(rows, breaks) if len(each)]


def beyond(values: Array, period_s: float, band_hz: float) -> Array:
    """Return the part of a signal ``(row, ...)`` above a frequency: a Butterworth high pass of
    order 4 forwards and backwards, without phase, by its response f^8/(f^8 + band^8).

    Its ends are continued by reflection in its last point: a force that ends in a slope goes on.
    """
    return _above(values, period_s, band_hz, "odd", 1.0)[0]


def powers(values: Array, period_s: float, band_hz: float) -> tuple[Array, Array]:
    """Return the power of a signal ``(row, dof)`` beyond a frequency and within it, row by row.
    Beyond it, half of the square of the envelope: it has no ripple at twice the frequency of an
    oscillation.

    The ends are mirrored, which keeps the mean: an oscillation ends anywhere in its cycle, and
    reflected in that point it would swing about it.
    """
    fast, later = _above(values, period_s, band_hz, "even", 1.0, -1j)  # by a quarter of a cycle
    return 0.5 * np.sum(fast**2 + later**2, axis=-1), np.sum((values - fast) ** 2, axis=-1)


def _above(
    values: Array, period_s: float, band_hz: float, ends: Literal["odd", "even"],
    *factors: complex,
) -> list[Array]:  # fmt: skip
    """Return the part above a frequency for each factor of its spectrum. Behind the end the
    signal goes on as far as makes a length that is transformed fast.
    """
    from scipy import fft  # takes long to import, and only this needs it

    rows = len(values)
    if band_hz * period_s >= HIGHEST or rows < 30:
        return [np.zeros_like(values) for _ in factors]
    pad = min(rows - 1, round(3.0 / (band_hz * period_s)))
    count = fft.next_fast_len(rows + 2 * pad, real=True)
    wide = [(pad, count - rows - pad), *[(0, 0)] * (values.ndim - 1)]
    whole = np.pad(values, wide, "reflect", reflect_type=ends)
    ratio = fft.rfftfreq(count, period_s) / band_hz
    passed = ratio**8 / (1.0 + ratio**8)
    spectrum = fft.rfft(whole, axis=0) * passed.reshape(-1, *[1] * (values.ndim - 1))
    return [fft.irfft(factor * spectrum, count, axis=0)[pad : pad + rows] for factor in factors]
