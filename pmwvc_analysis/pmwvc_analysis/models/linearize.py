# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact linear model of a scenario: the laws of a session, perturbed over one hyperperiod.

All periods (frames of every user, steps of the server) fit into the hyperperiod a whole number of
times. Over it the state goes on by a constant matrix::

    z(n+1) = A z(n) + B f(n),      y(n) = C z(n) + D f(n)

with f the hands' forces held over every tick, and y motion and force at the start of every tick,
both lifted: user by user, tick by tick, axis by axis. A is the transition (monodromy) matrix.
Of all states those count that matter (:mod:`.matrices`).

**Rigid motions** are no instability: where nothing holds the users to the ground, all may stand
elsewhere (A t = t), and where nothing brakes them either, all may move on uniformly (A t = t up to
such a translation). Close to their eigenvalues, which are one exactly, there may be others that
matter; so they are taken out. With T an orthonormal basis of the translations, (I - T T^T) A has
the eigenvalues of A less those of T, and zeros in their place; a uniform motion is a translation
of that, and is taken out in turn. Where devices, object, deflections and springs are and how
devices and object move (``placed``, p) gives all other states s. With (A - I)[:, s] = Q U, they
leave of (A - I) t = 0 the small problem (I - Q Q^T)(A - I)[:, p] t_p = 0: what is zero there but
for rounding shows.

Equations: docs/theory.md 15.1, 15.2.
"""

from functools import cached_property
from typing import Any

import numpy as np

from pmwvc_analysis.models.loop import LinearLoop, held, loop_of
from pmwvc_analysis.models.matrices import reduced
from pmwvc_analysis.models.response import placed
from pmwvc_core.numeric import Array, Flags, Integers
from pmwvc_core.scenario.scenario import Scenario

ROUNDING = 1e-9  # of a radius
STANDING, MOVING_ON = 1e-10, 1e-12  # zero but for rounding, to the largest singular value or to 1


class Linear:
    """The linear model of one loop, or of several side by side, packets under way as states."""

    def __init__(self, loop: LinearLoop) -> None:
        states, whole = held(loop)
        stepped = np.delete(whole, np.s_[len(states) : len(states) + loop.sent], axis=1)
        kept, rows = reduced(stepped, placed(states))
        n = self.count = len(kept)
        self.ticks, self.states = loop.ticks, [states[j] for j in kept]
        self.matrices = rows[:, :n, :n]  # A of every run, (runs, n, n)

    @cached_property
    def quotient(self) -> tuple[Array, Integers]:
        """A of every run without rigid motions, and how many each has; see :func:`quotient`."""
        return quotient(self.matrices, placed(self.states))

    def radii(self) -> Array:
        """Return the spectral radius of every run without rigid motions."""
        return np.asarray(np.abs(np.linalg.eigvals(self.quotient[0])).max(axis=-1))

    @property
    def motions(self) -> int:
        """Number of rigid motions of the first run."""
        return int(self.quotient[1][0])


def stable(radius: Any) -> Any:
    """Tell whether spectral radii mean stable: at most 1, but for rounding."""
    return radius <= 1.0 + ROUNDING


def build(scenario: Scenario, *, live: bool = False) -> LinearLoop:
    """Return the loop of a scenario, with the hands' forces and what is read."""
    return loop_of(scenario, live=live, outputs=True)


def spectral_radius(loop: LinearLoop) -> float:
    """Return the largest length of an eigenvalue of A without rigid motions."""
    return float(Linear(loop).radii()[0])


def quotient(matrices: Array, placed: Flags) -> tuple[Array, Integers]:
    """Return matrices ``(runs, n, n)`` without rigid motions, zeros in place of their eigenvalues,
    and how many each run has ``(runs,)``; ``placed`` are ``(n,)``, see module.
    """
    p, s, motions = np.flatnonzero(placed), np.flatnonzero(~placed), np.zeros(len(matrices), int)
    for zero in (STANDING, MOVING_ON):
        moves = matrices - np.eye(len(placed))
        orthogonal, upper = np.linalg.qr(moves[..., s])
        across = orthogonal.swapaxes(1, 2)
        left = moves[..., p] - orthogonal @ (across @ moves[..., p])
        _, sizes, rows = np.linalg.svd(left, full_matrices=False)
        still = (sizes <= zero * np.maximum(sizes[:, :1], 1.0))[:, np.newaxis, ::-1]
        basis = np.zeros((*matrices.shape[:2], len(p)))
        basis[:, p] = rows[:, ::-1].swapaxes(1, 2) * still  # translations, then zeros
        basis[:, s] = -np.linalg.solve(upper, across @ (moves[..., p] @ basis[:, p]))
        basis = np.linalg.qr(basis)[0] * still
        matrices = matrices - basis @ (basis.swapaxes(1, 2) @ matrices)
        motions += still.sum(axis=(1, 2))
    return matrices, motions
