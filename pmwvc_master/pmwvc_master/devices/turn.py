# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The turn of a handle as axes 4 to 6.

Its way is l times the sum of the turns between samples, each as a vector in world axes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pmwvc_core.params.fields import Validated, fixed

UNIT = 2e-3  # |q|^2 is 1 within


@dataclass(frozen=True)
class TurnParams(Validated):
    """What a driver's orientations need."""

    lever_m: float = fixed(0.05, "> 0 m", "l, the same as server.lever_m")


class Turn:
    """The way of a handle that turns [m]."""

    def __init__(self, lever_m: float) -> None:
        self.way, self.lever_m = np.zeros(3), lever_m
        self._turned: Rotation | None = None

    def add(self, quaternion: Sequence[float]) -> bool:
        """Take an orientation, a unit quaternion x y z w; tell whether it was one."""
        q = np.array(quaternion)
        if not abs(float(q @ q) - 1.0) < UNIT:
            return False
        turned = Rotation.from_quat(q)
        if self._turned is not None:
            self.way = self.way + self.lever_m * (turned * self._turned.inv()).as_rotvec()
        self._turned = turned
        return True
