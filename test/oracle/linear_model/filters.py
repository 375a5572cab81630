# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Anti-aliasing filters as blocks of the linear model; what rows are is said in :mod:`.blocks`."""

from typing import Protocol

import numpy as np
from oracle.linear_model.blocks import column
from oracle.linear_model.sections import Sections

from pmwvc_core.numeric import Array
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.filter_design import design


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
        self._inside = Sections(sos)
        self.names = ("y", *self._inside.names)
        self._y: Array = np.zeros((1, 1))

    @property
    def state(self) -> list[Array]:
        """One row per name."""
        return [self._y, *self._inside.state]

    @state.setter
    def state(self, rows: list[Array]) -> None:
        self._y, self._inside.state = rows[0], rows[1:]

    def step(self, u: Array) -> None:
        """Advance all sections."""
        self._y = self._inside.step(u)

    def sample(self) -> Array:
        """Return the output after the last tick."""
        return self._y

    def steady(self, u: Array) -> list[Array]:
        """Return the states under a constant wave."""
        return [self._inside.at_rest(u), *self._inside.steady(u)]


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
