# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The minimum of a function of one variable between two bounds, by golden section."""

import math
from collections.abc import Callable
from typing import NamedTuple

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


class Minimum(NamedTuple):
    """The least value and its location."""

    at: float
    value: float


def minimum_between(
    function: Callable[[float], float], low: float, high: float, *, within: float = 1e-9
) -> Minimum:
    """Return the minimum of a function with one minimum between ``low`` and ``high``; of several
    one of them. ``within``: how precisely it is located.
    """
    step = GOLDEN * (high - low)
    left, right = high - step, low + step
    at_left, at_right = function(left), function(right)
    while high - low > within:
        if at_left <= at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = function(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = function(right)
        if not low < left < right < high:  # no floats in between
            break
    return Minimum(left, at_left) if at_left <= at_right else Minimum(right, at_right)
