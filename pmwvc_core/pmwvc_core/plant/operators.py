# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Operators by name: who holds the device."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from pmwvc_core.errors import RecordingError
from pmwvc_core.numeric import Array, Value
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.plant.forces import Chirp, Constant, NoHand, Operator, RecordedForce, Sinusoid
from pmwvc_core.plant.hand import Hand, RecordedHand
from pmwvc_core.plant.playback import load_recording
from pmwvc_core.plant.remote_hand import RemoteHand
from pmwvc_core.plant.targets import TaskTargets, targets_from
from pmwvc_core.plant.task import Task

__all__ = ["OPERATORS", "Operator", "make_operator"]


class Setting(NamedTuple):
    """Position and side of an operator, and the rate at which it acts."""

    side: int
    half_width: Value
    start: Value
    tick_s: float
    dof: int


def _force(kind: type[Constant | Sinusoid | Chirp]) -> "Maker":
    return lambda params, task, at: kind(params, tick_s=at.tick_s, dof=at.dof)


def _no_hand(params: OperatorParams, task: TaskParams, at: Setting) -> Operator:
    return NoHand(tick_s=at.tick_s, dof=at.dof)


def _hand(params: OperatorParams, task: TaskParams, at: Setting) -> Operator:
    return Hand(params, Task(task), **at._asdict())


def _remote(params: OperatorParams, task: TaskParams, at: Setting) -> Operator:
    hand = RemoteHand(params, start=at.start, tick_s=at.tick_s, dof=at.dof)
    if params.file:
        hand.source = targets_from(params, tick_s=at.tick_s, dof=at.dof)
    else:
        hand.source = TaskTargets(params, Task(task), **at._asdict())
    return hand


def _recorded_force(params: OperatorParams, task: TaskParams, at: Setting) -> Operator:
    return RecordedForce(
        _recording(params, at), repeat=params.repeat, tick_s=at.tick_s, dof=at.dof
    )


def _recorded_motion(params: OperatorParams, task: TaskParams, at: Setting) -> Operator:
    return RecordedHand(
        params, _recording(params, at), start=at.start, tick_s=at.tick_s, dof=at.dof
    )


def _recording(params: OperatorParams, at: Setting) -> Array:
    recording = load_recording(
        params.file,
        columns=params.columns,
        time_column=params.time_column,
        rate_hz=params.rate_hz,
        scale=params.scale,
        offset=params.offset,
        fade_s=params.fade_s,
        tick_s=at.tick_s,
    )
    count = recording.shape[1]
    if count not in (1, at.dof):
        raise RecordingError(
            f"{params.file}: operator.columns = {params.columns!r} are {count} columns for "
            f"{at.dof} axes; give one column (it acts along the first axis) or one per axis"
        )
    return recording


Maker = Callable[[OperatorParams, TaskParams, Setting], Operator]
OPERATORS: Mapping[str, Maker] = {
    "none": _no_hand,
    "constant": _force(Constant),
    "sinusoid": _force(Sinusoid),
    "chirp": _force(Chirp),
    "hand": _hand,
    "remote": _remote,
    "playback_force": _recorded_force,
    "playback_motion": _recorded_motion,
}


def make_operator(
    params: OperatorParams,
    task: TaskParams,
    *,
    side: int,
    half_width: Value,
    tick_s: float,
    dof: int,
    start: Value,
) -> Operator:
    """Return the operator ``params.kind`` names, at the beginning of its time.

    Parameters
    ----------
    params, task
        Who, and what to do.
    side
        -1: left of the object, pushing towards +x; +1: right of it.
    half_width
        Half the object's width [m].
    tick_s, dof
        Period of the force loop [s]; number of axes, of which axis 0 carries the task.
    start
        Where the device is at first, along axis 0 [m].

    Raises
    ------
    ParameterError
        If the hand would not be stable at this tick.
    RecordingError
        If a recording cannot be used.
    """
    return OPERATORS[params.kind](params, task, Setting(side, half_width, start, tick_s, dof))
