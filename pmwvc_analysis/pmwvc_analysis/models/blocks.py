# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Blocks of the linear model, from the parameters alone: device, anti-aliasing filter, hold.

A signal is a *row*: an array ``(runs, width)`` that says how the signal depends on the state at
the start of the hyperframe and on the hands' forces in it. A block keeps one row per state and
applies its own matrices to them, tick by tick; at the end its rows are rows of the transition
matrix. Parameters may differ from run to run, as columns ``(runs, 1)``.

Every block says by ``steady`` what its states are while everything moves on uniformly and no
force acts: one of the motions that are no instability (:mod:`.rigid`).
"""

from typing import Protocol

import numpy as np

from pmwvc_core.numeric import Array, Value
from pmwvc_core.params import DeviceParams, FilterParams
from pmwvc_core.plant.motion import motion
from pmwvc_core.wave.filter_design import design


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


class Filter(Protocol):
    """Anti-aliasing filter with the rate drop behind it."""

    names: tuple[str, ...]
    state: list[Array]

    def step(self, u: Array) -> None:
        """Take the wave of one tick."""

    def sample(self) -> Array:
        """Return what a packet carries; called at a frame start."""

    def steady(self, u: Array) -> list[Array]:
        """Return the states under a constant wave."""


class Passing:
    """No filter: a packet carries the wave of the last tick."""

    names: tuple[str, ...] = ("u",)

    def __init__(self) -> None:
        self.state: list[Array] = []

    def step(self, u: Array) -> None:
        """Keep the wave."""
        self.state = [u]

    def sample(self) -> Array:
        """Return it."""
        return self.state[0]

    def steady(self, u: Array) -> list[Array]:
        """Return the wave."""
        return [u]


class Cascade:
    """Sections of second order one after the other, y = b0 u + s1, s1+ = b1 u - a1 y + s2,
    s2+ = b2 u - a2 y; states of sections of first order are left out.
    """

    def __init__(self, sos: Array) -> None:
        self._sections = [[column(c) for c in section] for section in sos]
        self._second = [bool(np.any(s[[2, 5]])) for s in sos]
        self._first = [
            second or bool(np.any(s[[1, 4]])) for second, s in zip(self._second, sos, strict=True)
        ]
        names = ["y"]
        for place, (first, second) in enumerate(zip(self._first, self._second, strict=True)):
            names += [f"s{place}1"] * first + [f"s{place}2"] * second
        self.names = tuple(names)
        self.state: list[Array] = []

    def step(self, u: Array) -> None:
        """Advance all sections."""
        old, new = iter(self.state[1:]), []
        for (b0, b1, b2, _, a1, a2), first, second in zip(
            self._sections, self._first, self._second, strict=True
        ):
            y = b0 * u + next(old) if first else b0 * u
            if first:
                s2 = next(old) if second else 0.0
                new.append(b1 * u - a1 * y + s2)
            if second:
                new.append(b2 * u - a2 * y)
            u = y
        self.state = [u, *new]

    def sample(self) -> Array:
        """Return the output after the last tick."""
        return self.state[0]

    def steady(self, u: Array) -> list[Array]:
        """Return the states under a constant wave."""
        found = []
        for (b0, b1, b2, _, a1, a2), first, second in zip(
            self._sections, self._first, self._second, strict=True
        ):
            y = u * (b0 + b1 + b2) / (1.0 + a1 + a2)
            found += [y - b0 * u] if first else []
            found += [b2 * u - a2 * y] if second else []
            u = y
        return [u, *found]


class FirstOrder:
    """y+ = p y + (1-p) u; the output after a tick already holds that tick."""

    names: tuple[str, ...] = ("y",)

    def __init__(self, p: Array) -> None:
        self._p = p
        self.state: list[Array] = []

    def step(self, u: Array) -> None:
        """Advance one tick."""
        self.state = [self._p * self.state[0] + (1.0 - self._p) * u]

    def sample(self) -> Array:
        """Return the output after the last tick."""
        return self.state[0]

    def steady(self, u: Array) -> list[Array]:
        """Return the wave."""
        return [u]


class IntegrateAndDump:
    """The mean over the frame."""

    names: tuple[str, ...] = ("sum",)

    def __init__(self, rate_drop: int) -> None:
        self._rate_drop = rate_drop
        self.state: list[Array] = []

    def step(self, u: Array) -> None:
        """Add the wave of a tick."""
        self.state = [self.state[0] + u]

    def sample(self) -> Array:
        """Return the mean and begin the next frame."""
        mean = self.state[0] / self._rate_drop
        self.state = [0.0 * mean]
        return mean

    def steady(self, u: Array) -> list[Array]:
        """Return the sum of a whole frame."""
        return [u * self._rate_drop]


def make_filter(params: FilterParams, *, tick_s: float, rate_drop: int) -> Filter:
    """Return the filter ``params.kind`` names."""
    if params.kind == "none":
        return Passing()
    if params.kind == "integrate_and_dump":
        return IntegrateAndDump(rate_drop)
    sos = design(params, tick_s=tick_s)
    if params.kind == "first_order":
        return FirstOrder(column(-sos[0, 4]))
    return Cascade(sos)


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
