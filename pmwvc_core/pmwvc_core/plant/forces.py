# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Operators that push with a given force, whatever the device does; and what all operators share.

A given force is an ideal source: nothing limits the energy it can deliver, so it suits experiments
(App. B Fig. 5 uses 1 N from each side) rather than the picture of a person; for that see ``hand``.
"""

import math
from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array, Value, dot
from pmwvc_core.params import OperatorParams
from pmwvc_core.plant.devices import along_first_axis


class Setting(NamedTuple):
    """Place and side of an operator, and the rate at which it acts."""

    side: int  # -1: left of the object, pushing towards +x; +1: right of it
    half_width: Value  # half the object's width [m]
    start: Value  # where the device is at first, along axis 0 [m]
    tick_s: float  # period of the force loop
    dof: int  # number of axes, of which axis 0 carries the task


class Operator(ABC):
    """The operator who holds the device. Its time starts with its first ``step``."""

    SIGNALS = "_x _f_h"
    MEMORY = "work_j _ticks"

    def __init__(self, *, tick_s: float, dof: int) -> None:
        self.tick_s = tick_s
        self.axis: Value = along_first_axis(1.0, dof)
        self.work_j: Value = (
            0.0  # [J] done on the device up to the last step: sum of force times way
        )
        self._ticks = 0
        self._x: Value = 0.0
        self._f_h: Value = 0.0

    def step(self, x: Value, xd: Value) -> Value:
        """Return the force on the device over the tick that starts now [N], given position [m] and
        velocity [m/s] of the handle at this instant, ``(..., dof)``.
        """
        if self._ticks:
            self.work_j = self.work_j + dot(self._f_h, x - self._x)
        self._x = x
        self._f_h = f_h = self._force(x, xd)
        self._ticks += 1
        return f_h

    def hold(self) -> Value:
        """Return the force while there is nothing to do yet: none; time does not pass."""
        return 0.0 * self.axis

    @abstractmethod
    def _force(self, x: Value, xd: Value) -> Value:
        """Return the force for this tick, number ``self._ticks``."""


class NoHand(Operator):
    """No operator: the device is free."""

    def _force(self, x: Value, xd: Value) -> Value:
        return 0.0 * self.axis


class Constant(Operator):
    """The same force along axis 0 all the time."""

    def __init__(self, params: OperatorParams, *, tick_s: float, dof: int) -> None:
        super().__init__(tick_s=tick_s, dof=dof)
        self._constant = params.force * self.axis

    def _force(self, x: Value, xd: Value) -> Value:
        return self._constant


class Sinusoid(Operator):
    """A sine along axis 0, phase zero at the start."""

    def __init__(self, params: OperatorParams, *, tick_s: float, dof: int) -> None:
        super().__init__(tick_s=tick_s, dof=dof)
        self._amplitude = params.force * self.axis
        self._advance = 2.0 * math.pi * params.frequency_hz * tick_s

    def _force(self, x: Value, xd: Value) -> Value:
        return self._amplitude * _sine(self._advance * self._ticks)


class Chirp(Operator):
    """A sine along axis 0 whose frequency rises linearly, sweep after sweep, in one phase:
    phi(t) = 2 pi [n (f0 + f1) S/2 + f0 t + (f1 - f0) t^2/(2 S)], t since the start of sweep n.
    """

    def __init__(self, params: OperatorParams, *, tick_s: float, dof: int) -> None:
        super().__init__(tick_s=tick_s, dof=dof)
        self._amplitude = params.force * self.axis
        self._params = params

    def _force(self, x: Value, xd: Value) -> Value:
        sweep_s, first = self._params.sweep_s, self._params.frequency_hz
        last = self._params.frequency_end_hz
        sweep, time_s = divmod(self._ticks * self.tick_s, sweep_s)
        cycles = sweep * (first + last) * sweep_s / 2.0 + time_s * (
            first + (last - first) * time_s / (2.0 * sweep_s)
        )
        return self._amplitude * _sine(2.0 * math.pi * cycles)


class RecordedForce(Operator):
    """A recorded force, one row of ``(ticks, dof)`` [N] per tick; none after its end."""

    def __init__(self, recording: Array, *, repeat: bool, tick_s: float, dof: int) -> None:
        super().__init__(tick_s=tick_s, dof=dof)
        self._rows = rows_of(recording, dof)
        self._repeat = repeat

    def _force(self, x: Value, xd: Value) -> Value:
        if self._repeat:
            return self._rows[self._ticks % len(self._rows)]
        return self._rows[self._ticks] if self._ticks < len(self._rows) else 0.0 * self.axis


def rows_of(recording: Array, dof: int) -> list[Value]:
    """Return the rows as signals: floats for one axis; a single column goes to axis 0."""
    if dof == 1:
        return [float(row) for row in recording[:, 0]]
    return [along_first_axis(row, dof) for row in recording]


def _sine(value: Value) -> Value:
    return np.sin(value) if isinstance(value, np.ndarray) else math.sin(value)


class ForceOnRecord(RecordedForce):
    """The force of a recorded hand, one row per tick, ``(ticks, dof)`` [N]; none after its end.

    It does not react: where the replayed device meets another force than the recorded one did,
    nothing brings it back to where the hand would have held it. The recording knows itself when
    the hand began, so time passes from the first tick, coupled or not. Rows that are not numbers
    (not recorded) are no force.
    """

    def __init__(self, recording: Array, *, tick_s: float, dof: int) -> None:
        super().__init__(recording, repeat=False, tick_s=tick_s, dof=dof)

    def hold(self) -> Value:
        """Return the recorded force of this tick [N]."""
        f_h = self._force(0.0, 0.0)
        self._ticks += 1
        return f_h
