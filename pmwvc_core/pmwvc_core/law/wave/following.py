# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The wave impedance that follows contact: b in free motion, r b in contact, 1 <= r <= n.

Both ends form the waves u, v of b. Behind r b they are sqrt(r) u and sqrt(r) v::

    F = r (b xd - sqrt(2b) v),    F xd = r (|u|^2 - |v|^2)/2,    u + v = sqrt(2b) xd

The server's end decides: from ``FORCE_N`` on and ``KEEP_S`` longer r rises over ``RISE_S``.
Packets carry the level, 0 (r = 1) to ``LEVELS`` (r = n). Equations: docs/theory.md 17.28.
"""

from typing import NamedTuple

from pmwvc_core.law.vectors import Vector, squared

FORCE_N, KEEP_S = 0.05, 0.06
RISE_S, FALL_S = 0.1, 0.05
LEVELS = 255.0


class Following(NamedTuple):
    """The impedance of a server's port, over b."""

    ratio: float  # r
    level: float
    left_s: float  # for which it counts as in contact


FREE = Following(1.0, 0.0, 0.0)


def ratio_of(level: float, most: float) -> float:
    """Return r for a level of packets."""
    return 1.0 + (most - 1.0) * (level / LEVELS)


def followed(s: Following, f: Vector, h: float, most: float) -> Following:
    """Go on by a step of h seconds, after a contact force [N]."""
    if most <= 1.0:
        return s
    left_s = KEEP_S if squared(f) > FORCE_N**2 else max(s.left_s - h, 0.0)
    change = LEVELS * h / (RISE_S if left_s > 0.0 else -FALL_S)
    level = max(min(s.level + change, LEVELS), 0.0)
    return Following(ratio_of(float(int(level)), most), level, left_s)
