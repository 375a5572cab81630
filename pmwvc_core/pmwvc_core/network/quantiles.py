# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A distribution given by quantiles, joined by straight lines."""

import bisect
import functools
import itertools
import math
from dataclasses import dataclass

from pmwvc_core.errors import ParameterError

FORM = "must be probability:seconds from 0 to 1, rising, separated by blanks"


@dataclass(frozen=True)
class Quantiles:
    """Probabilities from 0 to 1, and the value at each [s]."""

    probability: tuple[float, ...]
    value_s: tuple[float, ...]

    def at(self, u: float) -> float:
        """Return the quantile [s] of a number in [0, 1]."""
        p, x = self.probability, self.value_s
        k = min(bisect.bisect_right(p, u), len(p) - 1) - 1
        return x[k] + (x[k + 1] - x[k]) * (u - p[k]) / (p[k + 1] - p[k])

    @functools.cached_property
    def moments(self) -> tuple[float, float]:
        """Return mean and standard deviation [s]."""
        mean = square = 0.0
        points = itertools.pairwise(zip(self.probability, self.value_s, strict=True))
        for (p, x), (q, y) in points:
            mean += (q - p) * (x + y) / 2.0
            square += (q - p) * (x * x + x * y + y * y) / 3.0
        return mean, math.sqrt(max(square - mean * mean, 0.0))


@functools.lru_cache(maxsize=64)
def quantiles_of(text: str) -> Quantiles:
    """Read the quantiles of ``link.jitter_quantiles``.

    Raises
    ------
    ParameterError
        If the text gives none; with its value and what it must be.
    """
    refused = ParameterError(f"jitter_quantiles = {text!r}: {FORM}")
    try:
        pairs = [tuple(map(float, word.split(":"))) for word in text.split()]
        probability, value_s = (tuple(column) for column in zip(*pairs, strict=True))
    except ValueError:
        raise refused from None
    rising = all(a < b for a, b in itertools.pairwise(probability))
    right = rising and probability[0] == 0.0 and probability[-1] == 1.0
    growing = all(a <= b for a, b in itertools.pairwise(value_s))
    if not right or not growing or not 0.0 <= value_s[0] <= value_s[-1] <= 60.0:
        raise refused
    return Quantiles(probability, value_s)
