# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The task of the hands as functions of time (App. B Fig. 6 shows such a target).

``carry``: the target rests at the origin until ``move_s``, moves to ``distance_m`` along the first
axis (and ``sideways_m`` along the second) and back again with a pause after each move, for ever.
Every move is the minimum-jerk one s(r) = 10 r^3 - 15 r^4 + 6 r^5, the same that closes the hands.
``hold`` has the closing only, ``free`` nothing.
"""

import numpy as np

from pmwvc_core.numeric import Value
from pmwvc_core.params import TaskParams


def minimum_jerk(progress: float) -> float:
    """Return s(r), with r held between 0 and 1."""
    if progress <= 0.0:
        return 0.0
    if progress >= 1.0:
        return 1.0
    return progress * progress * progress * (10.0 + progress * (6.0 * progress - 15.0))


class Task:
    """Target of the object and closing of the hands; time in s from the moment of coupling."""

    def __init__(self, params: TaskParams) -> None:
        self.params = params
        self._move_s, self._rise_s = params.move_s, params.move_rise_s
        self._leg_s = params.move_rise_s + params.rest_s
        self._distance_m = params.distance_m
        self._moves = params.moves
        self._closes = params.closes

    def offset(self, time_s: float, *, dof: int) -> Value:
        """Return the position of the target along all axes [m]."""
        if dof == 1:
            return self._distance_m * self._progress(time_s)
        offset = np.zeros(dof)
        offset[:2] = self._distance_m, self.params.sideways_m
        return offset * self._progress(time_s)

    def _progress(self, time_s: float) -> float:
        """Return how far the target is on its way, 0 to 1."""
        since = time_s - self._move_s
        if since <= 0.0 or not self._moves:
            return 0.0
        leg, within_s = divmod(since, self._leg_s)
        progress = minimum_jerk(within_s / self._rise_s)
        return 1.0 - progress if leg % 2 else progress

    def closing(self, time_s: float) -> float:
        """Return how far the hands have closed, 0 (open) to 1."""
        if not self._closes:
            return 0.0
        return minimum_jerk((time_s - self.params.grip_s) / self.params.grip_rise_s)
