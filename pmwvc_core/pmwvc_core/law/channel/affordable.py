# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The part that energy covers of a change of a wave, and of the repayment of a displacement.

Equations: docs/theory.md 17.14.
"""

import math

from pmwvc_core.law.vectors import Vector, dot, scaled, squared

SLOWLY_S, QUICKLY_S = 0.7, 0.1


def affordable(wave: Vector, change: Vector, power: float) -> tuple[Vector, float]:
    """Return as much of a change w of a wave v [sqrt(W)] as the energy covers, and its cost.

    That is the longest s w, 0 <= s <= 1, with |v + s w|^2 - |v|^2 <= power, which is twice the
    power that may be spent: |v|^2 is 2 W. A change that makes the wave smaller brings energy: its
    cost is negative.
    """
    along, size = dot(wave, change), squared(change)
    cost = 2.0 * along + size
    if cost <= power:
        return change, cost
    ratio = 0.0
    if size > 0.0:
        most = math.sqrt(along * along + max(size * power, 0.0)) - along
        ratio = max(min(most / size, 1.0), 0.0)
    return scaled(change, ratio), ratio * (2.0 * along + ratio * size)


def repayment(undelivered: Vector, wave: Vector, free_j: float) -> Vector:
    """Return the wave that delivers what is undelivered [sqrt(W) s], as fast as its energy allows.

    A wave w along what is undelivered, U, beside v, costs v + w/2 for each part of it. So with an
    energy E that may be spent [J], w = 2 (E/|U| - v), within the time constants ``SLOWLY_S`` and
    ``QUICKLY_S``.
    """
    size = math.sqrt(squared(undelivered))
    if size == 0.0:
        return undelivered
    along = scaled(undelivered, 1.0 / size)
    wanted = min(2.0 * (free_j / size - dot(wave, along)), size * (1.0 / QUICKLY_S))
    return scaled(along, max(wanted, size * (1.0 / SLOWLY_S)))
