# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions that are no instability, and the transition matrix without them.

Where nothing holds the users to the ground, all may stand elsewhere (A t = t), and where nothing
brakes them either, all may move on uniformly (A t = t up to such a translation). These eigenvalues
are one exactly, and close by there may be others that matter; so they are not looked for among
eigenvalues, but taken out. With T an orthonormal basis of the translations,

    A' = (I - T T^T) A

has the eigenvalues of A less those that were 1 by a translation, and zeros in their place; a
uniform motion is a translation of A'.

Where devices, object, deflections and springs are and how devices and object move (``placed``, p)
gives all other states s. With (A - I)[:, s] = Q U, what they leave of (A - I) t = 0 is a small
problem, ``(I - Q Q^T)(A - I)[:, p] t_p = 0``: what is zero there but for rounding shows clearly.

Equations: docs/theory.md 15.2.
"""

import numpy as np

from pmwvc_core.numeric import Array, Flags, Integers

STANDING, MOVING = 1e-10, 1e-12  # zero but for rounding, to the largest singular value or to 1


def quotient(matrices: Array, placed: Flags) -> tuple[Array, Integers]:
    """Return matrices ``(runs, n, n)`` with zeros in place of the eigenvalues that rigid motions
    have, and how many motions each run has ``(runs,)``; ``placed`` are ``(n,)``, see module.
    """
    motions = np.zeros(len(matrices), dtype=np.int64)
    for rounding in (STANDING, MOVING):
        basis = _translations(matrices, placed, rounding)
        matrices = matrices - basis @ (basis.swapaxes(1, 2) @ matrices)
        motions += np.count_nonzero(basis.any(axis=1), axis=1)
    return matrices, motions


def _translations(matrices: Array, placed: Flags, rounding: float) -> Array:
    """Return the t with A t = t: orthonormal columns, or zero, ``(runs, n, number of p)``."""
    p, s = np.flatnonzero(placed), np.flatnonzero(~placed)
    moves = matrices - np.eye(len(placed))
    orthogonal, upper = np.linalg.qr(moves[..., s])
    by_others = orthogonal.swapaxes(1, 2) @ moves[..., p]
    _, sizes, rows = np.linalg.svd(moves[..., p] - orthogonal @ by_others, full_matrices=False)
    free = sizes <= rounding * np.maximum(sizes[:, :1], 1.0)
    found = np.zeros((*matrices.shape[:2], len(p)))
    found[:, p] = rows.swapaxes(1, 2) * free[:, np.newaxis]
    found[:, s] = -np.linalg.solve(upper, by_others @ found[:, p])
    basis, sizes, _ = np.linalg.svd(found, full_matrices=False)
    return np.asarray(basis * (sizes > 0.5)[:, np.newaxis])  # of length 1 in p alone, or zero
