# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The task of the hands, and what pushes the device, by the type of its state; here given forces,
whatever the device does: ideal sources, for experiments (App. B Fig. 5 uses 1 N from each side).
For a person see ``hand``.

The task is a function of time [s] from coupling on (App. B Fig. 6 shows such a target). ``carry``:
from ``move_s`` on the target moves ``distance_m`` along the first axis (``sideways_m`` along the
second) and back, with pauses, for ever. Every move is the minimum-jerk one s(r) = 10 r^3 - 15 r^4
+ 6 r^5, which closes the hands, too. ``hold`` has the closing only, ``free`` nothing.
"""

import math
from typing import NamedTuple

import numpy as np

from pmwvc_core.law.family import Family
from pmwvc_core.law.vectors import Vector, row, scaled, zero
from pmwvc_core.numeric import Array
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
    way_m = (params.distance_m, params.sideways_m, params.upwards_m, 0.0, 0.0, 0.0)[:axes]
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


# (s, x, xd, acts, p) -> (s, f_h [N]) over this tick; no time passes before a hand ``acts``.
hand_force = Family("hand_force")


class GivenForce(NamedTuple):
    """A force along axis 0: constant, or a sine with phase zero at the start, whose frequency may
    rise linearly, sweep after sweep, in one phase: phi(t) = 2 pi [n (f0 + f1) S/2 + f0 t +
    (f1 - f0) t^2/(2 S)], t since the start of sweep n.
    """

    ticks: int


class ForceParams(NamedTuple):
    """Force along axis 0, and how it changes."""

    force: Vector  # [N] amplitude
    swings: bool  # else it is constant
    tick_s: float
    first_hz: float  # f0
    last_hz: float  # f1
    sweep_s: float  # S


@hand_force.member(GivenForce)
def _given(
    s: GivenForce, x: Vector, xd: Vector, acts: bool, p: ForceParams
) -> tuple[GivenForce, Vector]:
    if not acts:
        return s, zero(x)
    if not p.swings:
        return s, p.force
    sweep, time_s = divmod(s.ticks * p.tick_s, p.sweep_s)
    cycles = sweep * (p.first_hz + p.last_hz) * p.sweep_s / 2.0 + time_s * (
        p.first_hz + (p.last_hz - p.first_hz) * time_s / (2.0 * p.sweep_s)
    )
    return GivenForce(s.ticks + 1), scaled(p.force, math.sin(2.0 * math.pi * cycles))


class RecordedForce(NamedTuple):
    """A recorded force, one row per tick, whatever the device does."""

    ticks: int


class RecordedParams(NamedTuple):
    """A recording of forces."""

    rows: Array  # (ticks, axes) [N]
    axes: tuple[int, ...]  # numbers of the axes: 0, 1 ...
    repeat: bool  # else there is no force after its end
    early: bool  # its time passes from the first tick, coupled or not


def recorded_params(recording: Array, axes: int, repeat: bool, early: bool) -> RecordedParams:
    """Return the parameters of a recorded force, ``(ticks, 1 or axes)`` [N]."""
    return RecordedParams(rows_of(recording, axes), tuple(range(axes)), repeat, early)


def rows_of(recording: Array, axes: int) -> Array:
    """Return the rows of a recording along all axes; a single column goes to axis 0."""
    rows = np.zeros((len(recording), axes))
    rows[:, : recording.shape[1]] = recording
    return rows


@hand_force.member(RecordedForce)
def _recorded(
    s: RecordedForce, x: Vector, xd: Vector, acts: bool, p: RecordedParams
) -> tuple[RecordedForce, Vector]:
    if not acts and not p.early:
        return s, zero(x)
    number, after = s.ticks, RecordedForce(s.ticks + 1)
    if p.repeat:
        number = number % len(p.rows)
    return after, row(number, p.rows, p.axes) if number < len(p.rows) else zero(x)
