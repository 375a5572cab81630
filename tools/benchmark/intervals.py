# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Medians and ratios with 95 % intervals, by bootstrap over networks and over seeds in each.

Sessions on one network are alike, so whole networks are drawn with replacement, and then sessions
within each. A failed session has infinite errors: it stays in every median.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array

DRAWS = 2000


class Interval(NamedTuple):
    """An estimate and its 95 % interval."""

    value: float
    low: float
    high: float


def median(values: Array) -> Interval:
    """Return the median of values ``(networks, seeds)``, some of them infinite."""
    return _interval(values, _upper_median)


def ratio(values: Array) -> Interval:
    """Return the mean of values ``(networks, seeds)`` that are 0 or 1."""
    return _interval(values, lambda each: each.mean(axis=-1))


def _upper_median(values: Array) -> Array:
    """Return the median of the last axis: no mean of two, of which one may be infinite."""
    found: Array = np.sort(values, axis=-1)[..., values.shape[-1] // 2]
    return found


def _interval(values: Array, statistic: Callable[[Array], Array]) -> Interval:
    networks, seeds = values.shape
    rng = np.random.default_rng(networks * 1000 + seeds)
    rows = rng.integers(networks, size=(DRAWS, networks, 1))
    columns = rng.integers(seeds, size=(DRAWS, networks, seeds))
    drawn = np.sort(statistic(values[rows, columns].reshape(DRAWS, -1)))
    low, high = drawn[[round(0.025 * (DRAWS - 1)), round(0.975 * (DRAWS - 1))]]
    return Interval(float(statistic(values.reshape(-1))), float(low), float(high))
