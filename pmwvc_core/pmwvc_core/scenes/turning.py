# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Rotations as matrices, and how they change in a step.

Cayley's step is a rotation for any rate, and moves R linearly in the mean of both ends::

    cay(a) = (1 - [a]/2)^-1 (1 + [a]/2),   R1 = R0 cay(a)  <=>  R1 - R0 = (R0 + R1)/2 [a]
                                           R1 = cay(a) R0  <=>  R1 - R0 = [a] (R0 + R1)/2

with [a] b = a x b; it turns by 2 atan(|a|/2).
"""

import numpy as np

from pmwvc_core.numeric import Array

ONE = np.eye(3)
# By axis: the rows of [a] behind one another.
_CROSSED = np.array(
    [[0, 0, 0, 0, 0, -1, 0, 1, 0], [0, 0, 1, 0, 0, 0, -1, 0, 0], [0, -1, 0, 1, 0, 0, 0, 0, 0]],
    dtype=float,
)


def cross(a: Array) -> Array:
    """Return [a], ``(..., 3, 3)``, of vectors ``(..., 3)``."""
    return np.asarray((a @ _CROSSED).reshape(*a.shape, 3))


def cayley(a: Array) -> Array:
    """Return cay(a) = 1 + ([a] + [a]^2/2)/(1 + |a|^2/4), ``(..., 3, 3)``."""
    turn = cross(a)
    share = 1.0 / (1.0 + 0.25 * np.sum(a * a, axis=-1))
    return np.asarray(ONE + share[..., None, None] * (turn + 0.5 * turn @ turn))
