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

**Rigid motions** are no instability: where nothing holds the users to the ground, all may stand
elsewhere (A t = t), and where nothing brakes them either, all may move on uniformly (A t = t up to
such a translation). Close to their eigenvalues, which are one exactly, there may be others that
matter; so they are taken out. With T an orthonormal basis of the translations, (I - T T^T) A has
the eigenvalues of A less those of T, and zeros in their place; a uniform motion is a translation
of that. Where devices, object, deflections and springs are and how devices and object move
(``placed``, p) gives all other states s. With (A - I)[:, s] = Q U, they leave of (A - I) t = 0 the
small problem (I - Q Q^T)(A - I)[:, p] t_p = 0: what is zero there but for rounding shows.

Equations: docs/theory.md 15.1, 15.2.
"""

from collections.abc import Iterable, Sequence
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.hyperperiod import PLACED, Hyperperiod, StateName
from pmwvc_analysis.models.outside import checked
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Flags, Integers
from pmwvc_core.scenario.scenario import Scenario

ROUNDING = 1e-9  # of a radius
STANDING, MOVING = 1e-10, 1e-12  # zero but for rounding, to the largest singular value or to 1
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
        """A of every run without rigid motions, and how many each has; see :func:`quotient`."""
        return quotient(self.matrices, placed(self.columns))

    def radii(self) -> Array:
        """Return the spectral radius of every run without rigid motions."""
        return np.asarray(np.abs(np.linalg.eigvals(self.quotient[0])).max(axis=-1))

    def stable(self) -> Flags:
        """Tell of every run whether it is stable."""
        return np.asarray(stable(self.radii()))


def stable(radius: Any) -> Any:
    """Tell whether spectral radii mean stable: at most 1, but for rounding."""
    return radius <= 1.0 + ROUNDING


def linearize(
    *runs: Scenario, live: bool = False, weights: Sequence[int] = (), outputs: bool = False
) -> Linear:
    """Return the linear model of scenarios without inputs; parameters as :class:`.loop.Loop`,
    raises what :func:`.outside.checked` raises.
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


def quotient(matrices: Array, placed: Flags) -> tuple[Array, Integers]:
    """Return matrices ``(runs, n, n)`` without rigid motions, zeros in place of their eigenvalues,
    and how many each run has ``(runs,)``; ``placed`` are ``(n,)``, see module.
    """
    p, s = np.flatnonzero(placed), np.flatnonzero(~placed)
    moves = matrices - np.eye(len(placed))
    orthogonal, upper = np.linalg.qr(moves[..., s])
    across = orthogonal.swapaxes(1, 2)

    def left(values: Array) -> Array:
        return values - orthogonal @ (across @ values)

    def whole(places: Array, goes: Array | float) -> Array:
        """Return the z with these places and (A - I) z as given."""
        z = np.zeros((*matrices.shape[:2], places.shape[2]))
        z[:, p] = places
        z[:, s] = np.linalg.solve(upper, across @ (goes - moves[..., p] @ places))
        return z

    columns, sizes, rows = np.linalg.svd(left(moves[..., p]), full_matrices=False)
    motions = np.sum(sizes <= STANDING * np.maximum(sizes[:, :1], 1.0), axis=1)
    if np.ptp(motions):  # runs with as many translations at a time
        found, counts = np.empty_like(matrices), np.empty_like(motions)
        for translations in np.unique(motions):
            of = motions == translations
            found[of], counts[of] = quotient(matrices[of], placed)
        return found, counts
    held = len(p) - int(motions[0])
    still = whole(rows[:, held:].swapaxes(1, 2), 0.0)
    driven = np.concatenate([columns[..., :held] * sizes[:, np.newaxis, :held], -left(still)], 2)
    _, sizes, turns = np.linalg.svd(driven, full_matrices=False)
    free = (sizes <= MOVING * np.maximum(sizes[:, :1], 1.0))[:, ::-1]
    along = (turns[:, ::-1] * free[..., np.newaxis]).swapaxes(1, 2)  # uniform motions, then zeros
    uniform = whole(rows[:, :held].swapaxes(1, 2) @ along[:, :held], still @ along[:, held:])
    basis = np.linalg.qr(np.concatenate([still, uniform], axis=2))[0]
    motions = motions + free.sum(axis=1)
    basis = basis * (np.arange(basis.shape[2]) < motions[:, np.newaxis])[:, np.newaxis]
    return matrices - basis @ (basis.swapaxes(1, 2) @ matrices), motions
