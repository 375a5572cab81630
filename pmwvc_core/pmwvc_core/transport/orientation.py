# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Orientations in packets, x y z w, world axes: of length 1, and q is the same as -q."""

import math
from collections.abc import Sequence
from operator import mul

Orientation = tuple[float, ...]
IDENTITY = (0.0, 0.0, 0.0, 1.0)
UNIT = 1e-3  # these are as long as 1 within


def unit(q: Sequence[float], last: Sequence[float]) -> Orientation:
    """Return it with length 1 and the sign nearer to the last one; () for what is none."""
    size = math.hypot(*q) if len(q) == len(IDENTITY) else 0.0
    if not abs(size - 1.0) <= UNIT:
        return ()
    size = -size if sum(map(mul, q, last)) < 0.0 else size
    return tuple(each / size for each in q)


def carried(q: Orientation, turn: Sequence[float]) -> Orientation:
    """Return exp(turn) q, for a turn in world axes [rad]."""
    angle = math.hypot(*turn)
    sine = math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5
    (x, y, z), w, (e, f, g, h) = (sine * each for each in turn), math.cos(0.5 * angle), q
    return (
        w * e + x * h + y * g - z * f, w * f + y * h + z * e - x * g,
        w * g + z * h + x * f - y * e, w * h - x * e - y * f - z * g,
    )  # fmt: skip
