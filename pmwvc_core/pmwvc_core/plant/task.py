# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the hands are asked to do, as functions of time (App. B Fig. 6 shows such a target).

``carry``: the target rests at the origin until ``move_s``, moves to ``distance_m`` and back again
with a pause after each move, for ever. Every move is the minimum-jerk one
s(r) = 10 r^3 - 15 r^4 + 6 r^5, the same that closes the hands. ``hold`` has the closing only,
``free`` nothing.
"""

from pmwvc_core.params import TaskParams


def minimum_jerk(share: float) -> tuple[float, float]:
    """Return s(r) and ds/dr, with r held between 0 and 1."""
    if share <= 0.0:
        return 0.0, 0.0
    if share >= 1.0:
        return 1.0, 0.0
    rest = 1.0 - share
    return (
        share * share * share * (10.0 + share * (6.0 * share - 15.0)),
        30.0 * share * share * rest * rest,
    )


class Task:
    """Target of the object and closing of the hands; time in s from the moment of coupling."""

    def __init__(self, params: TaskParams) -> None:
        self.params = params
        self._leg_s = params.move_rise_s + params.rest_s
        self._moves = params.kind == "carry"
        self._closes = params.kind != "free"

    def target(self, time_s: float) -> tuple[float, float]:
        """Return position [m] and velocity [m/s] of the target along axis 0."""
        since = time_s - self.params.move_s
        if not self._moves or since <= 0.0:
            return 0.0, 0.0
        leg, within_s = divmod(since, self._leg_s)
        share, slope = minimum_jerk(within_s / self.params.move_rise_s)
        distance = self.params.distance_m
        if leg % 2:
            share, slope = 1.0 - share, -slope
        return distance * share, distance * slope / self.params.move_rise_s

    def closing(self, time_s: float) -> tuple[float, float]:
        """Return how far the hands have closed, 0 (open) to 1, and its rate [1/s]."""
        if not self._closes:
            return 0.0, 0.0
        share, slope = minimum_jerk((time_s - self.params.grip_s) / self.params.grip_rise_s)
        return share, slope / self.params.grip_rise_s


class ShownTarget:
    """The target as the server shows it.

    The hands begin once the force is there (``master.client``), so the target begins when all
    users have been together for the length of the soft start.

    Parameters
    ----------
    task
        Where the target is to be.
    period_s
        Time step of the server [s].
    soft_start_s
        How long the masters take until their hands begin [s].
    """

    def __init__(self, task: Task, *, period_s: float, soft_start_s: float) -> None:
        self.position_m = 0.0
        self._task = task
        self._period_s = period_s
        self._time_s: float | None = None
        self._soft_start_s = soft_start_s

    def step(self, *, together: bool) -> float:
        """Return the position [m] for a step, told whether all users are there now."""
        if self._time_s is not None:
            self._time_s += self._period_s
        elif together:
            self._time_s = -self._soft_start_s
        self.position_m = 0.0 if self._time_s is None else self._task.target(self._time_s)[0]
        return self.position_m
