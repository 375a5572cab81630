# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The turn of a handle as axes 4 to 6.

Its way is l times the sum of the turns between samples, each as a vector in world axes, from unit
quaternions (x, y, z, w)::

    q = q1 q0*, of the two signs that with w >= 0:   2 atan2(|v|, w) v/|v|
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmwvc_core.params.fields import Validated, fixed

UNIT = 2e-3  # |q|^2 is 1 within


@dataclass(frozen=True)
class TurnParams(Validated):
    """What a driver's orientations need."""

    lever_m: float = fixed(0.05, "> 0 m", "l, the same as server.lever_m")


class Turn:
    """The way of a handle that turns [m]."""

    def __init__(self, lever_m: float) -> None:
        self.way, self.lever_m, self._q = np.zeros(3), lever_m, np.zeros(0)

    def add(self, quaternion: Sequence[float]) -> bool:
        """Take an orientation; tell whether it was one."""
        q = np.array(quaternion)
        if not abs(float(q @ q) - 1.0) < UNIT:
            return False
        before = self._q if len(self._q) else q
        v, w, v0, w0 = q[:3], q[3], before[:3], before[3]
        by, cosine = w0 * v - w * v0 - np.cross(v, v0), w * w0 + v @ v0
        size = float(np.linalg.norm(by))
        if size > 0.0:
            angle = 2.0 * math.atan2(size, abs(cosine))
            self.way = self.way + self.lever_m * angle / math.copysign(size, cosine) * by
        self._q = q
        return True
