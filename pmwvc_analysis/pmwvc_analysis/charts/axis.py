# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Axes of a drawing: from values to picture coordinates, and round numbers to label."""

import math
from dataclasses import dataclass

import numpy as np

from pmwvc_core.numeric import Array

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
