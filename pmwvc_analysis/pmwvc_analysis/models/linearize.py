# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact linear model of a scenario: the laws of a session, perturbed over one hyperperiod.

All periods (frames of every user, steps of the server) fit into the hyperperiod a whole number of
times. Over it the state goes on by a constant matrix::

    z(n+1) = A z(n) + B f(n),      y(n) = C z(n) + D f(n)

with f the hands' forces held over every tick, and y motion and force at the start of every tick,
both lifted: user by user, tick by tick, axis by axis. A is the transition (monodromy) matrix.
States that are not read, not driven, or present twice are left out, where entries are exactly zero
or rows exactly equal in every run: that changes no eigenvalue other than zero, nor what follows
from the inputs.

Equations: docs/theory.md 15.1.
"""

from collections.abc import Iterable, Sequence
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.hyperperiod import PLACED, Hyperperiod, StateName
from pmwvc_analysis.models.outside import checked
from pmwvc_analysis.models.rigid import quotient
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Flags, Integers
from pmwvc_core.scenario.scenario import Scenario

ROUNDING = 1e-9  # of a radius
LARGEST_LIFTED = 4000  # users times ticks times axes
LARGEST_STATES = 3000  # of a model with inputs and outputs: some 10 s and 200 MB


class Output(NamedTuple):
    """One lifted output y = C z + D f; rows, and columns of D, by
    ``(user * ticks + tick) * dof + axis``.
    """

    state: Array  # C, (users * ticks * dof, n)
    through: Array  # D, (users * ticks * dof, users * ticks * dof)


class Linear:
    """The linear model of one scenario, or of several side by side."""

    def __init__(
        self,
        loop: Hyperperiod,
        columns: dict[StateName, int],  # of every state
        rows: Array,  # (runs, states, states and inputs), the states after the hyperperiod
        read: dict[str, Array],  # (runs, signals, states and inputs), what was read of them
    ) -> None:
        n, several = len(columns), loop.dof > 1
        self.loop, self.columns, self.rows, self.read = loop, columns, rows, read
        self.ticks = loop.ticks  # of the hyperperiod
        self.states = [f"{name}, axis {axis}" if several else name for name, axis in columns]
        self.matrices = rows[:, :, :n]  # A of every run, (runs, n, n)
        # Of the first run: A, (n, n); B, (n, inputs), per N of a hand pushing the device; outputs.
        self.transition, self.inputs = np.split(rows[0], [n], axis=1)
        self.outputs = {name: Output(y[0, :, :n], y[0, :, n:]) for name, y in read.items()}

    @cached_property
    def quotient(self) -> tuple[Array, Integers]:
        """A of every run without rigid motions, and how many each has; see :mod:`.rigid`."""
        return quotient(self.matrices, placed(self.columns))

    def radii(self) -> Array:
        """Return the spectral radius of every run without rigid motions."""
        return np.asarray(np.abs(np.linalg.eigvals(self.quotient[0])).max(axis=-1))

    def stable(self) -> Flags:
        """Tell of every run whether it is stable."""
        return np.asarray(stable(self.radii()))


def stable(radius: Any) -> Any:
    """Tell whether a spectral radius means stable, or which of several do: no eigenvalue is
    outside the unit circle, beyond rounding.
    """
    return radius <= 1.0 + ROUNDING


def linearize(
    *runs: Scenario, live: bool = False, weights: Sequence[int] = (), outputs: bool = False
) -> Linear:
    """Return the linear model of scenarios; see :class:`.loop.Loop` for what is asked. Its inputs
    are left out. Raises what :func:`.outside.checked` raises.
    """
    loop_of = kept_loop if len(runs) == 1 else kept_loop.__wrapped__
    loop = loop_of(*runs, live=live, weights=tuple(weights))
    return model_of(loop, list(loop.paths), *loop.around(outputs=outputs))


@lru_cache(maxsize=8)
def kept_loop(*runs: Scenario, live: bool, weights: tuple[int, ...]) -> Hyperperiod:
    """Return a loop: one for all that is asked of a scenario in a row."""
    return checked(*runs, live=live, weights=weights)


def build(scenario: Scenario, *, live: bool = False, weights: Sequence[int] = ()) -> Linear:
    """Return the model of a scenario, with inputs and outputs; NonlinearError if an element is not
    linear, PmwvcError if the hyperperiod is too long, or there are too many states or inputs.
    """
    loop = checked(scenario, live=live, weights=weights)
    lifted, states = len(loop.lines) * loop.ticks * loop.dof, len(loop.paths) * loop.dof
    if states > LARGEST_STATES:
        raise PmwvcError(
            f"{scenario.name}: {states} states, nearly all of them packets in flight, "
            f"more than {LARGEST_STATES}; shorten link.delay_s (pmwvc stability takes any delay)"
        )
    if lifted > LARGEST_LIFTED:
        raise PmwvcError(
            f"{scenario.name}: {lifted} inputs (users times ticks of the hyperperiod, along each "
            f"axis), more than {LARGEST_LIFTED}; choose rate_drop and period_s with common factors"
        )
    return model_of(loop, list(loop.paths), *loop.around(inputs=True, outputs=True))


def spectral_radius(model: Linear) -> float:
    """Return the largest length of an eigenvalue of A without rigid motions."""
    return float(model.radii()[0])


def model_of(
    loop: Hyperperiod, states: Sequence[StateName], rows: Array, read: dict[str, Array]
) -> Linear:
    """Return the model of what was stepped, on those of its states that matter."""
    kept, whole = reduced(np.concatenate([rows, *read.values()], axis=1), placed(states))
    columns = {states[j]: index for index, j in enumerate(kept)}
    ends = np.cumsum([len(kept), *(each.shape[1] for each in read.values())])[:-1]
    left, *signals = np.split(whole, ends, axis=1)
    return Linear(loop, columns, left, dict(zip(read, signals, strict=True)))


def placed(states: Iterable[StateName]) -> Flags:
    """Tell of every state whether it is one that gives a rigid motion ``(n,)``."""
    return np.array([name.endswith(PLACED) for name, _ in states], dtype=np.bool_)


def reduced(whole: Array, always: Flags) -> tuple[list[int], Array]:
    """Return the states that matter, and the matrix on them alone.

    ``whole`` is ``(runs, n and signals, n and inputs)``: the n states after a step, and what is
    read of them otherwise; ``always`` are ``(n,)`` states that matter in any case.
    """
    n, whole = len(always), whole.copy()
    filled = np.any(whole != 0.0, axis=0)  # entries other than zero in any run
    kept = np.arange(n)
    while True:
        twins = _twins(whole, kept, always)
        for twin, first in twins.items():
            whole[:, :, first] += whole[:, :, twin]
            filled[:, first] = np.any(whole[:, :, first] != 0.0, axis=0)
        still = np.setdiff1d(kept, list(twins))
        own = still[:, np.newaxis] == np.arange(whole.shape[2])
        columns = np.r_[still, n : whole.shape[2]]
        driven = np.any((filled[still] & ~own)[:, columns], axis=1)
        others = filled[still] & ~(own & (whole[0, still] == 1.0))  # a sum only it reads is none
        seen = others.any(axis=0) | filled[n:].any(axis=0)
        left = still[always[still] | (driven & seen[still])]
        gone = np.setdiff1d(kept, left)
        whole[:, :, gone], filled[:, gone] = 0.0, False
        if len(left) == len(kept):
            rows = np.r_[kept, n : whole.shape[1]]
            return kept.tolist(), whole[:, rows[:, np.newaxis], np.r_[kept, n : whole.shape[2]]]
        kept = left


def _twins(whole: Array, kept: Integers, always: Flags) -> dict[int, int]:
    """Return states that are equal to an earlier one after every step."""
    first: dict[bytes, int] = {}  # by their rows in every run
    return {
        j: earlier
        for j in kept.tolist()
        if (earlier := first.setdefault((whole[:, j] + 0.0).tobytes(), j)) != j and not always[j]
    }
