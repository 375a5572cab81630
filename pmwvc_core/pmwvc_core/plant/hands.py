# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands by name, at the beginning of their time: state and parameters of the laws."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.law.vectors import Vector
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.plant.forces import (
    Chirp,
    ConstantForce,
    ForceParams,
    RecordedForce,
    Sine,
    recorded_params,
    rows_of,
)
from pmwvc_core.plant.hand import (
    RecordedHand,
    grip_of,
    hand_params,
    recorded_motion,
    resting_hand,
)
from pmwvc_core.plant.playback import load_recording, read_columns
from pmwvc_core.plant.remote_hand import remote_params, resting_remote
from pmwvc_core.plant.targets import POINTER_S, PointerParams, TableHand, TableParams, TaskHand
from pmwvc_core.plant.task import task_of


class Place(NamedTuple):
    """Place and side of a hand, and the rate at which it acts."""

    side: int  # -1: left of the object, pushing towards +x; +1: right of it
    half_width_m: float  # half the object's width
    start_m: float  # where the device is at first, along axis 0
    tick_s: float  # period of the force loop
    axes: int  # of which axis 0 carries the task

    @property
    def start(self) -> Vector:
        """Where the device is at first [m]."""
        return self.along(self.start_m)

    def along(self, value: float) -> Vector:
        """Return a vector along axis 0."""
        return (value, *(0.0,) * (self.axes - 1))


Made = tuple[Any, Any]  # state and parameters
Maker = Callable[[OperatorParams, TaskParams, Place], Made]


def _none(params: OperatorParams, task: TaskParams, at: Place) -> Made:
    return ConstantForce(0), ForceParams(at.along(0.0), at.tick_s, 0.0, 0.0, 1.0)


def _force(kind: Callable[[int], Any]) -> Maker:
    return lambda params, task, at: (
        kind(0),
        ForceParams(
            at.along(params.force), at.tick_s, params.frequency_hz, params.frequency_end_hz,
            params.sweep_s,
        ),
    )  # fmt: skip


def _hand(params: OperatorParams, task: TaskParams, at: Place) -> Made:
    grip = grip_of(params, params.mass, at.tick_s)
    p = hand_params(
        params, task_of(task, at.axes), grip, at.side, at.half_width_m, at.start_m, at.tick_s
    )
    return resting_hand(p), p


def _recorded_force(params: OperatorParams, task: TaskParams, at: Place) -> Made:
    recording = load_recording(params, tick_s=at.tick_s, dof=at.axes)
    return RecordedForce(0), recorded_params(recording, at.axes, params.repeat, False)


def _recorded_motion(params: OperatorParams, task: TaskParams, at: Place) -> Made:
    recording = load_recording(params, tick_s=at.tick_s, dof=at.axes)
    return RecordedHand(0), recorded_motion(params, recording, at.start, at.tick_s)


def _remote(params: OperatorParams, task: TaskParams, at: Place) -> Made:
    hand, p = resting_remote(at.start), remote_params(params, at.tick_s)
    if params.file:
        return TableHand(hand, 0, 0), _table(params, at)
    inside = params.squeeze / params.remote.stiffness
    pressed = at.along(at.side * (at.half_width_m - inside))
    every = max(1, round(POINTER_S / at.tick_s))
    return TaskHand(hand, 0), PointerParams(p, task_of(task, at.axes), at.start, pressed, every)


def _table(params: OperatorParams, at: Place) -> TableParams:
    """Return the targets of the file ``params.file``: a row per target, the time [s] from the
    moment the user is coupled, and the position [m] on one axis or on each. A row with ``nan``
    lets go.
    """
    if not params.time_column:
        raise RecordingError(
            f"{params.file}: operator.time_column is empty; a remote hand needs the times of its "
            "targets: name their column"
        )
    values, times = read_columns(params, dof=at.axes)
    if not np.isfinite(times).all() or np.any(np.diff(times) < 0.0):
        raise RecordingError(
            f"{params.file}: {params.time_column} must be finite and must not go back"
        )
    ticks = np.ceil(times / at.tick_s - 1e-6).astype(int)
    rows = rows_of(params.scale * values + params.offset, at.axes)
    return TableParams(remote_params(params, at.tick_s), ticks, rows, tuple(range(at.axes)), False)


HANDS: Mapping[str, Maker] = {
    "none": _none,
    "constant": _force(ConstantForce),
    "sinusoid": _force(Sine),
    "chirp": _force(Chirp),
    "hand": _hand,
    "remote": _remote,
    "playback_force": _recorded_force,
    "playback_motion": _recorded_motion,
}


def make_hand(params: OperatorParams, task: TaskParams, at: Place) -> Made:
    """Return state and parameters of the hand ``params.kind`` names; ParameterError where it would
    not be stable at this tick, RecordingError where a recording cannot be used.
    """
    return HANDS[params.kind](params, task, at)
