# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Unit quaternions x y z w on plain floats, in world axes: a tick has no time for a library."""

import math
from collections.abc import Sequence
from operator import mul

from pmwvc_core.numeric import Array

Orientation = tuple[float, ...]
IDENTITY = (0.0, 0.0, 0.0, 1.0)
UNIT = 1e-3  # in packets these are as long as 1 within


def product(q: Orientation, p: Orientation) -> Orientation:
    """Return q p: first p, then q."""
    (x, y, z, w), (e, f, g, h) = q, p
    return (
        w * e + x * h + y * g - z * f, w * f + y * h + z * e - x * g,
        w * g + z * h + x * f - y * e, w * h - x * e - y * f - z * g,
    )  # fmt: skip


def carried(q: Orientation, turn: Sequence[float]) -> Orientation:
    """Return exp(turn) q, for a turn in world axes [rad]."""
    angle = math.hypot(*turn)
    sine = math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5
    return product((*(sine * each for each in turn), math.cos(0.5 * angle)), q)


def turn_between(before: Orientation, q: Orientation) -> tuple[float, float, float]:
    """Return the shorter turn in world axes that carries one to the other [rad]."""
    e, f, g, h = before
    x, y, z, w = product(q, (-e, -f, -g, h))
    sine = math.copysign(math.hypot(x, y, z), w)
    share = 2.0 * math.atan2(abs(sine), abs(w)) / sine if sine else 2.0
    return share * x, share * y, share * z


def of_matrix(matrix: Array) -> Orientation:
    """Return it for a rotation matrix ``(3, 3)``."""
    a, b, c, d, e, f, g, h, i = matrix.ravel().tolist()
    every = (  # q times 4 x, 4 y, 4 z and 4 w: the longest is the most exact
        (1.0 + a - e - i, b + d, c + g, h - f),
        (b + d, 1.0 - a + e - i, f + h, c - g),
        (c + g, f + h, 1.0 - a - e + i, d - b),
        (h - f, c - g, d - b, 1.0 + a + e + i),
    )
    longest = max(every, key=lambda row: math.hypot(*row))
    size = math.hypot(*longest)
    return tuple(each / size for each in longest)


def unit(q: Sequence[float], last: Sequence[float]) -> Orientation:
    """Return it with length 1 and the sign nearer to the last one; () for what is none."""
    size = math.hypot(*q) if len(q) == len(IDENTITY) else 0.0
    if not abs(size - 1.0) <= UNIT:
        return ()
    size = -size if sum(map(mul, q, last)) < 0.0 else size
    return tuple(each / size for each in q)
