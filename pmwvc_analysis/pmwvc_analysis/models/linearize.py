# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact linear model of a scenario: the laws of a session, perturbed over one hyperperiod.

All periods (frames of every user, steps of the server) fit into the hyperperiod a whole number of
times. Over it the state goes on by a constant matrix::

    z(n+1) = A z(n) + B f(n),      y(n) = C z(n) + D f(n)

with f the hands' forces held over every tick, and y motion and force at the start of every tick,
both lifted: user by user, tick by tick, axis by axis. A is the transition (monodromy) matrix.
Of all states those count that matter (:mod:`.response`).

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

from functools import cached_property
from typing import Any

import numpy as np

from pmwvc_analysis.models.linear import axes_of
from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.models.loop import LinearLoop, held, loop_of
from pmwvc_analysis.models.response import placed, reduced
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Flags, Integers
from pmwvc_core.scenario.scenario import Scenario

ROUNDING = 1e-9  # of a radius
STANDING, MOVING_ON = 1e-10, 1e-12  # zero but for rounding, to the largest singular value or to 1
LARGEST_LIFTED = 1000  # users times ticks times axes


class Linear:
    """The linear model of one loop, or of several side by side, packets under way as states."""

    def __init__(self, loop: LinearLoop) -> None:
        states, whole = held(loop)
        stepped = np.delete(whole, np.s_[len(states) : len(states) + loop.sent], axis=1)
        kept, rows = reduced(stepped, placed(states))
        names = [states[j] for j in kept]
        n = self.count = len(kept)
        self.loop, self.ticks = loop, loop.ticks
        self.columns = {name: index for index, name in enumerate(names)}
        self.states = [f"{name}, axis {axis}" if loop.dof > 1 else name for name, axis in names]
        self.matrices = rows[:, :n, :n]  # A of every run, (runs, n, n)
        self.transition = self.matrices[0]

    @cached_property
    def quotient(self) -> tuple[Array, Integers]:
        """A of every run without rigid motions, and how many each has; see :func:`quotient`."""
        return quotient(self.matrices, placed(self.columns))

    def radii(self) -> Array:
        """Return the spectral radius of every run without rigid motions."""
        return np.asarray(np.abs(np.linalg.eigvals(self.quotient[0])).max(axis=-1))

    @property
    def motions(self) -> int:
        """Number of rigid motions of the first run."""
        return int(self.quotient[1][0])

    def largest(self) -> complex:
        """Return the longest eigenvalue of the first run."""
        values = np.linalg.eigvals(self.quotient[0][0])
        return complex(values[np.argmax(np.abs(values))])


def stable(radius: Any) -> Any:
    """Tell whether spectral radii mean stable: at most 1, but for rounding."""
    return radius <= 1.0 + ROUNDING


def build(scenario: Scenario, *, live: bool = False) -> LinearLoop:
    """Return the loop of a scenario, with the hands' forces and what is read; PmwvcError also for
    too many inputs.
    """
    dof, ticks = axes_of(scenario), hyperperiod_ticks(scenario)
    if (lifted := len(scenario.users) * ticks * dof) > LARGEST_LIFTED:
        raise PmwvcError(
            f"{scenario.name}: {lifted} inputs (users times ticks of the hyperperiod, along each "
            f"axis), more than {LARGEST_LIFTED}; choose rate_drop and period_s with common factors"
        )
    return loop_of(scenario, live=live, outputs=True)


def spectral_radius(loop: LinearLoop) -> float:
    """Return the largest length of an eigenvalue of A without rigid motions."""
    return float(Linear(loop).radii()[0])


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
    free = (sizes <= MOVING_ON * np.maximum(sizes[:, :1], 1.0))[:, ::-1]
    along = (turns[:, ::-1] * free[..., np.newaxis]).swapaxes(1, 2)  # uniform motions, then zeros
    uniform = whole(rows[:, :held].swapaxes(1, 2) @ along[:, :held], still @ along[:, held:])
    basis = np.linalg.qr(np.concatenate([still, uniform], axis=2))[0]
    motions = motions + free.sum(axis=1)
    basis = basis * (np.arange(basis.shape[2]) < motions[:, np.newaxis])[:, np.newaxis]
    return matrices - basis @ (basis.swapaxes(1, 2) @ matrices), motions
