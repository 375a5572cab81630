# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The task of the hands as functions of time [s] from coupling on (App. B Fig. 6 shows such a
target). ``carry``: from ``move_s`` on the target moves ``distance_m`` along the first axis
(``sideways_m`` along the second) and back, with pauses, for ever. Every move is the minimum-jerk
one s(r) = 10 r^3 - 15 r^4 + 6 r^5, which closes the hands, too. ``hold`` has the closing only,
``free`` nothing.
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, scaled
from pmwvc_core.params import TaskParams


class Task(NamedTuple):
    """What the hands do, and when."""

    way_m: Vector  # of the target
    moves: bool
    move_s: float  # begins
    rise_s: float  # one move
    leg_s: float  # one move and the pause after it
    closes: bool
    grip_s: float  # begins
    grip_rise_s: float


def task_of(params: TaskParams, axes: int) -> Task:
    """Return the task along so many axes."""
    way_m = (params.distance_m, params.sideways_m, *(0.0,) * axes)[:axes]
    leg_s = params.move_rise_s + params.rest_s
    return Task(way_m, params.moves, params.move_s, params.move_rise_s, leg_s, params.closes,
                params.grip_s, params.grip_rise_s)  # fmt: skip


def minimum_jerk(progress: float) -> float:
    """Return s(r), with r held between 0 and 1."""
    if progress <= 0.0:
        return 0.0
    if progress >= 1.0:
        return 1.0
    return progress * progress * progress * (10.0 + progress * (6.0 * progress - 15.0))


def closing(time_s: float, p: Task) -> float:
    """Return how far the hands have closed, 0 (open) to 1."""
    return minimum_jerk((time_s - p.grip_s) / p.grip_rise_s) if p.closes else 0.0


def offset(time_s: float, p: Task) -> Vector:
    """Return the position of the target [m]."""
    since = time_s - p.move_s
    if since <= 0.0 or not p.moves:
        return scaled(p.way_m, 0.0)
    leg, within_s = divmod(since, p.leg_s)
    progress = minimum_jerk(within_s / p.rise_s)
    return scaled(p.way_m, 1.0 - progress if leg % 2.0 else progress)
