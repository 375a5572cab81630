# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Targets of a remote hand in simulation: recorded ones from a file, or those of the task.

A file has a row per target: the time [s] from the moment the user is coupled, and the position [m]
on one axis or on each. A row with ``nan`` lets go. Between rows nothing comes: a gap of more than
``SILENT_S`` lets go as well.

Without a file the task is done by somebody with a pointer, a target every ``POINTER_S``: on the
user's face of the object, and ``squeeze / stiffness`` inside it once the hands have closed.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.numeric import signal
from pmwvc_core.params import OperatorParams
from pmwvc_core.plant.devices import along_first_axis
from pmwvc_core.plant.forces import Setting
from pmwvc_core.plant.playback import read_columns
from pmwvc_core.plant.remote_hand import Target
from pmwvc_core.plant.task import Task

POINTER_S = 0.016


class GivenTargets:
    """Targets at given ticks, in the order of time: when each comes, and where [m]; None lets go.
    Ticks count from the moment of coupling; with ``early`` from the start of the force loop.
    """

    MEMORY = "_tick _next"

    def __init__(self, targets: Iterable[tuple[int, Target]], *, early: bool = False) -> None:
        self.early = early
        self._targets = list(targets)
        self._tick = self._next = 0

    def take(self) -> Sequence[Target]:
        """Return the targets of this tick."""
        targets, first = self._targets, self._next
        while self._next < len(targets) and targets[self._next][0] <= self._tick:
            self._next += 1
        self._tick += 1
        return [target for _, target in targets[first : self._next]]


class TaskTargets:
    """The targets of somebody who carries out a task with a pointer."""

    early = False
    MEMORY = "_tick"

    def __init__(self, params: OperatorParams, task: Task, at: Setting) -> None:
        self._task, self._dof, self._tick_s = task, at.dof, at.tick_s
        self._start = along_first_axis(at.start, at.dof)
        inside = params.squeeze / params.remote.stiffness
        self._pressed = along_first_axis(at.side * (at.half_width - inside), at.dof)
        self._every = max(1, round(POINTER_S / at.tick_s))
        self._tick = 0

    def take(self) -> Sequence[Target]:
        """Return the target of this tick, where one is due; none until the hands close."""
        time_s = self._tick * self._tick_s
        due = self._tick % self._every == 0
        self._tick += 1
        closed = self._task.closing(time_s) if due else 0.0
        if closed == 0.0:
            return ()
        position = self._start + closed * (self._pressed - self._start)
        return (position + self._task.offset(time_s, dof=self._dof),)


def targets_from(params: OperatorParams, *, tick_s: float, dof: int) -> GivenTargets:
    """Return the targets of the file ``params.file``; RecordingError saying which file, what it
    holds, and what to do.
    """
    if not params.time_column:
        raise RecordingError(
            f"{params.file}: operator.time_column is empty; a remote hand needs the times of its "
            "targets: name their column"
        )
    values, times = read_columns(params, dof=dof)
    if not np.isfinite(times).all() or np.any(np.diff(times) < 0.0):
        raise RecordingError(
            f"{params.file}: {params.time_column} must be finite and must not go back"
        )
    rows = params.scale * values + params.offset
    ticks = np.ceil(times / tick_s - 1e-6).astype(int).tolist()
    return GivenTargets((tick, _target(row, dof)) for tick, row in zip(ticks, rows, strict=True))


def _target(row: np.ndarray[tuple[int, ...], np.dtype[np.float64]], dof: int) -> Target:
    """Return a row of a file as a target; one that is not finite lets go."""
    if not np.isfinite(row).all():
        return None
    return signal([*row.tolist(), *[0.0] * (dof - len(row))], dof)
