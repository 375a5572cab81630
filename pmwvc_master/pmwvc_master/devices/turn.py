# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The turn of a handle as axes 4 to 6: l times the sum of the turns between samples."""

from collections.abc import Sequence

import numpy as np

from pmwvc_core.transport.orientation import unit


class Turn:
    """A handle that turns: its way with a lever [m], and its orientation x y z w."""

    def __init__(self, lever_m: float, orientation: tuple[float, ...] = ()) -> None:
        self.way, self.lever_m = np.zeros(3), lever_m
        self.orientation = orientation

    def add(self, quaternion: Sequence[float]) -> bool:
        """Take an orientation, a unit quaternion x y z w; tell whether it was one."""
        q, before = unit(quaternion, self.orientation), self.orientation
        if q and before:
            from scipy.spatial.transform import Rotation  # takes long; only six axes need it

            turn = Rotation.from_quat(q) * Rotation.from_quat(before).inv()
            self.way = self.way + self.lever_m * turn.as_rotvec()
        self.orientation = q or before
        return bool(q)
