# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands by name, at the beginning of their time: state and parameters of the laws."""

from typing import Any

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.plant.forces import (
    ForceParams,
    GivenForce,
    RecordedForce,
    recorded_params,
    rows_of,
)
from pmwvc_core.plant.hand import Place, RecordedHand, recorded_motion, task_hand
from pmwvc_core.plant.playback import load_recording, read_columns
from pmwvc_core.plant.remote_hand import (
    POINTER_S,
    PointerParams,
    TableHand,
    TableParams,
    TaskHand,
    remote_params,
    resting_remote,
)
from pmwvc_core.plant.task import task_of

Made = tuple[Any, Any]  # state and parameters


def make_hand(params: OperatorParams, task: TaskParams, at: Place) -> Made:
    """Return state and parameters of the hand ``params.kind`` names; ParameterError where it would
    not be stable at this tick, RecordingError where a recording cannot be used.
    """
    if params.is_hand:
        return task_hand(params, task, at)
    if params.is_remote:
        return _remote(params, task, at)
    if params.is_recorded:
        recording = load_recording(params, tick_s=at.tick_s, dof=at.axes)
        if params.answers:
            return RecordedHand(0), recorded_motion(params, recording, at.start, at.tick_s)
        return RecordedForce(0), recorded_params(recording, at.axes, params.repeat, False)
    amplitude = 0.0 if params.kind == "none" else params.force
    last_hz = params.frequency_end_hz if params.is_chirp else params.frequency_hz
    swings = params.is_sinusoid or params.is_chirp
    return GivenForce(0), ForceParams(
        at.along(amplitude), swings, at.tick_s, params.frequency_hz, last_hz, params.sweep_s
    )


def _remote(params: OperatorParams, task: TaskParams, at: Place) -> Made:
    """Return a hand that does the task, or has the targets of the file ``params.file``: a row per
    target, the time [s] from the moment the user is coupled, and the position [m] on one axis or
    on each. A row with ``nan`` lets go.
    """
    hand, p = resting_remote(at.start), remote_params(params, at.tick_s)
    if not params.file:
        inside = params.squeeze / params.remote.stiffness
        pressed = at.along(at.side * (at.half_width_m - inside))
        every = max(1, round(POINTER_S / at.tick_s))
        the_task = task_of(task, at.axes)
        return TaskHand(hand, 0), PointerParams(p, the_task, at.start, pressed, every)
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
    return TableHand(hand, 0, 0), TableParams(p, ticks, rows, tuple(range(at.axes)), False)
