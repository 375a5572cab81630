# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Operators by name: who holds the device."""

from collections.abc import Callable, Mapping

from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.plant.forces import (
    Chirp,
    Constant,
    NoHand,
    Operator,
    RecordedForce,
    Setting,
    Sinusoid,
)
from pmwvc_core.plant.hand import Hand, RecordedHand
from pmwvc_core.plant.playback import load_recording
from pmwvc_core.plant.remote_hand import RemoteHand
from pmwvc_core.plant.targets import TaskTargets, targets_from
from pmwvc_core.plant.task import Task

Maker = Callable[[OperatorParams, TaskParams, Setting], Operator]


def _force(kind: type[Constant | Sinusoid | Chirp]) -> Maker:
    return lambda params, task, at: kind(params, tick_s=at.tick_s, dof=at.dof)


def _remote(params: OperatorParams, task: TaskParams, at: Setting) -> Operator:
    hand = RemoteHand(params, start=at.start, tick_s=at.tick_s, dof=at.dof)
    if params.file:
        hand.source = targets_from(params, tick_s=at.tick_s, dof=at.dof)
    else:
        hand.source = TaskTargets(params, Task(task), at)
    return hand


def _recorded_force(params: OperatorParams, task: TaskParams, at: Setting) -> Operator:
    recording = load_recording(params, tick_s=at.tick_s, dof=at.dof)
    return RecordedForce(recording, repeat=params.repeat, tick_s=at.tick_s, dof=at.dof)


def _recorded_motion(params: OperatorParams, task: TaskParams, at: Setting) -> Operator:
    return RecordedHand(params, load_recording(params, tick_s=at.tick_s, dof=at.dof), at)


OPERATORS: Mapping[str, Maker] = {
    "none": lambda params, task, at: NoHand(tick_s=at.tick_s, dof=at.dof),
    "constant": _force(Constant),
    "sinusoid": _force(Sinusoid),
    "chirp": _force(Chirp),
    "hand": lambda params, task, at: Hand(params, Task(task), at),
    "remote": _remote,
    "playback_force": _recorded_force,
    "playback_motion": _recorded_motion,
}


def make_operator(params: OperatorParams, task: TaskParams, at: Setting) -> Operator:
    """Return the operator ``params.kind`` names, at the beginning of its time.

    Raises
    ------
    ParameterError
        If the hand would not be stable at this tick.
    RecordingError
        If a recording cannot be used.
    """
    return OPERATORS[params.kind](params, task, at)
