# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Blocks of the linear model, from the parameters alone: device and hold (and :mod:`.filters`).

A signal is a *row*: an array ``(runs, width)`` that says how the signal depends on the state at
the start of the hyperperiod and on the hands' forces in it. A block keeps one row per state and
applies its own matrices to them, tick by tick; at the end its rows are rows of the transition
matrix. Parameters may differ from run to run, as columns ``(runs, 1)``.

Every block says by ``steady`` what its states are while everything moves on uniformly and no
force acts: one of the motions that are no instability (:mod:`.rigid`).
"""

from typing import Protocol

import numpy as np
from oracle.linear_model.motion import motion

from pmwvc_core.numeric import Array, Value
from pmwvc_core.params import DeviceParams


def column(value: Value) -> Array:
    """Return a parameter as a column: ``(1, 1)``, or ``(runs, 1)`` where it differs."""
    return np.asarray(value, dtype=float).reshape(-1, 1)


class Block(Protocol):
    """Something with states.

    Attributes
    ----------
    names
        Of the states.
    state
        One row per name.
    """

    names: tuple[str, ...]
    state: list[Array]


class Device:
    """m x'' + b x' = f, exact under a force held over the tick (App. B, Eq. 2).

    The velocity read is the true one, or the difference of the last two positions over a tick.
    """

    def __init__(self, params: DeviceParams, *, tick_s: float) -> None:
        self._motion = motion(column(params.mass), column(params.damping), tick_s)
        self._tick_s = tick_s
        self._differences = params.velocity == "euler"
        self.names: tuple[str, ...] = ("x", "xd", "xd_read") if self._differences else ("x", "xd")
        self.state: list[Array] = []

    def read(self) -> tuple[Array, Array]:
        """Return the rows of position [m] and velocity [m/s] as measured."""
        return self.state[0], self.state[-1]

    def step(self, force: Array) -> None:
        """Advance one tick under a force [N]."""
        x, xd = self.state[:2]
        moved = self._motion.xd_x * xd + self._motion.f_x * force
        self.state = [x + moved, self._motion.xd_xd * xd + self._motion.f_xd * force]
        if self._differences:
            self.state.append(moved / self._tick_s)

    def steady(self, position: Array, velocity: Array) -> list[Array]:
        """Return the states in uniform motion."""
        return [position, velocity, velocity][: len(self.names)]


class Hold:
    """From packets back to ticks: zero-order, or v_m = v_{i-1} + (v_i - v_{i-1}) j/M.

    Parameters
    ----------
    kind, ticks
        ``zoh`` or ``foh``; M.
    phase
        Tick of the frame at which a packet is taken. Taken at its start, a packet leaves no more
        behind than its own value; taken later, the ramp crosses the start of a frame.
    """

    def __init__(self, kind: str, *, ticks: int, phase: int) -> None:
        self._ticks = ticks if kind == "foh" else 1
        self._done = ticks - phase
        ramps = self._ticks > 1
        self.names: tuple[str, ...] = ()
        if ramps or phase:
            self.names = ("v_start", "v") if ramps and phase else ("v",)
        self._start: Array = np.zeros((1, 1))
        self._target: Array = np.zeros((1, 1))

    @property
    def state(self) -> list[Array]:
        """One row per name."""
        return [self._start, self._target][2 - len(self.names) :]

    @state.setter
    def state(self, rows: list[Array]) -> None:
        if rows:
            self._start, self._target = rows[0], rows[-1]

    def load(self, v: Array) -> None:
        """Begin a frame with a packet."""
        self._start, self._target, self._done = self._value(), v, 0

    def step(self) -> Array:
        """Return the wave of the next tick."""
        self._done += 1
        return self._value()

    def _value(self) -> Array:
        if self._done >= self._ticks:
            return self._target
        return self._start + (self._target - self._start) * (self._done / self._ticks)

    def steady(self, v: Array) -> list[Array]:
        """Return the states under a constant wave."""
        return [v] * len(self.names)


class Kept:
    """Values that stay until others take their place."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names
        self.state: list[Array] = []
