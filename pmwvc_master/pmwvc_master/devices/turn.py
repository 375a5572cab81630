# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The turn of a handle as axes 4 to 6: l times the sum of the turns between samples."""

from collections.abc import Sequence

import numpy as np

from pmwvc_core.frame import STALE_NS
from pmwvc_core.quaternions import UNIT, of_matrix, turn_between, unit


class Turn:
    """A handle that turns: way [m] and rate [m/s] with a lever, and orientation x y z w."""

    def __init__(self, lever_m: float, orientation: tuple[float, ...] = ()) -> None:
        self.way, self.rate, self.lever_m = np.zeros(3), np.zeros(3), lever_m
        self.orientation, self._at_ns = orientation, 0

    def add(self, turned: Sequence[float], at_ns: int = 0) -> bool:
        """Take a unit quaternion x y z w, or a matrix by rows; tell whether it was one."""
        if len(turned) == 9:
            m = np.reshape(turned, (3, 3))
            turned = of_matrix(m) if abs(np.linalg.det(m) - 1) < UNIT else ()
        q, before, span_ns = unit(turned, self.orientation), self.orientation, at_ns - self._at_ns
        if q and before:
            by = self.lever_m * np.array(turn_between(before, q))
            fast = 1e9 / span_ns if 0 < span_ns <= STALE_NS else 0.0
            self.way, self.rate = self.way + by, fast * by
        self.orientation, self._at_ns = q or before, at_ns
        return bool(q)
