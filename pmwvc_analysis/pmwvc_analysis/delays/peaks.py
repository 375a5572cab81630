# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The maximum of a function of one variable, between two points."""

from collections.abc import Callable

import numpy as np

from pmwvc_core.numeric import Array

POINTS = 21  # of an interval, which then shrinks to a tenth


def refined(
    at: Callable[[Array], Array], low: float, high: float, *, rounds: int
) -> tuple[float, float]:
    """Return the largest value found, and where; ``at`` takes and returns ``(points,)``."""
    found = -np.inf, low
    for _ in range(rounds):
        points = np.linspace(low, high, POINTS)
        values = at(points)
        top = int(np.argmax(values))
        found = max(found, (float(values[top]), float(points[top])))
        low, high = points[max(top - 1, 0)], points[min(top + 1, POINTS - 1)]
    return found
