# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From values to a picture: axes with round numbers to label, and fewer points of a curve with the
same picture. Per column the first, the lowest, the highest and the last point are kept, so that no
peak is lost.
"""

import math
from dataclasses import dataclass

import numpy as np

from pmwvc_core.numeric import Array, Integers

ROUND_STEPS = (1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True)
class Axis:
    """Maps ``low``..``high`` to ``start``..``end`` (picture units), linear or logarithmic."""

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def at(self, values: Array) -> Array:
        """Return picture coordinates."""
        if self.log:
            ratio = np.log(np.maximum(values, 1e-300) / self.low) / math.log(self.high / self.low)
        else:
            ratio = (np.asarray(values) - self.low) / (self.high - self.low)
        return np.asarray(self.start + ratio * (self.end - self.start))

    @property
    def per_unit(self) -> float:
        """Return the width of one picture unit in values (linear axes)."""
        return (self.high - self.low) / abs(self.end - self.start)

    def ticks(self, wanted: int) -> list[tuple[float, str]]:
        """Return round values within the axis and their labels."""
        if self.log:
            first, last = math.ceil(math.log10(self.low)), math.floor(math.log10(self.high))
            return [(10.0**power, f"{10.0**power:g}") for power in range(first, last + 1)]
        raw = (self.high - self.low) / max(1, wanted)
        base = 10.0 ** math.floor(math.log10(raw))
        step = next(base * each for each in ROUND_STEPS if base * each >= raw * (1.0 - 1e-9))
        digits = max(0, -math.floor(math.log10(step) + 1e-9))
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        if first > last:  # two round values are further apart than the axis is long
            return self.ticks(wanted + 1)
        values = [number * step for number in range(first, last + 1)]
        return [(value, f"{value:.{digits}f}".replace("-", "−")) for value in values]


def segments(x: Array, y: Array, *, longest_step: float) -> list[Integers]:
    """Return the indices of each stretch without NaN or a longer step (0: of any length)."""
    rows = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if not len(rows):
        return []
    breaks = np.diff(rows) > 1
    if longest_step > 0.0:
        breaks |= np.diff(x[rows]) > longest_step
    return np.split(rows, np.flatnonzero(breaks) + 1)


def envelope(x: Array, y: Array, rows: Integers, *, column: float) -> Integers:
    """Return which of ``rows`` to draw where a column of the picture is ``column`` wide."""
    if len(rows) <= 4 or column <= 0.0:
        return rows
    columns = np.floor((x[rows] - x[rows[0]]) / column)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(columns)) + 1])
    if len(starts) > len(rows) / 4:
        return rows
    ends = np.concatenate([starts[1:], [len(rows)]])
    kept = [starts, ends - 1]
    values = y[rows]
    for extreme in (np.argmin, np.argmax):
        pairs = zip(starts, ends, strict=True)
        kept.append(np.array([start + extreme(values[start:end]) for start, end in pairs]))
    return np.asarray(rows[np.unique(np.concatenate(kept))])


def reduced(x: Array, y: Array, *, period: float, column: float) -> list[Integers]:
    """Return the indices of each stretch to draw; a gap narrower than a column is none."""
    step = max(1.5 * period, column) if period > 0.0 else 0.0
    return [envelope(x, y, part, column=column) for part in segments(x, y, longest_step=step)]
