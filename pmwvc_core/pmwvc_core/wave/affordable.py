# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The part that energy covers of a change of a wave, and of the repayment of a displacement.

Equations: docs/theory.md 17.14.
"""

from pmwvc_core.numeric import Value, anywhere, dot, maximum, minimum, root, squared, where

SLOWLY_S, QUICKLY_S = 0.7, 0.1


def affordable(wave: Value, change: Value, power: Value) -> tuple[Value, Value]:
    """Return as much of a change of a wave as the energy covers, and its cost.

    That is the longest s w, 0 <= s <= 1, with |v + s w|^2 - |v|^2 <= power. A change that makes
    the wave smaller brings energy: its cost is negative.

    Parameters
    ----------
    wave, change
        v and w [sqrt(W)].
    power
        What may be spent, twice as power: |wave|^2 is 2 W.
    """
    along, size = dot(wave, change), squared(change)
    cost = 2.0 * along + size
    if anywhere(cost > power):
        most = root(along * along + maximum(size * power, 0.0)) - along
        ratio = most / where(size > 0.0, size, 1.0)
        ratio = where(cost > power, maximum(minimum(ratio, 1.0), 0.0), 1.0)
        change = ratio * change
        cost = ratio * (2.0 * along + ratio * size)
    return change, cost


def repayment(undelivered: Value, wave: Value, free_j: Value) -> Value:
    """Return the wave that delivers what is undelivered, as fast as its energy allows [sqrt(W)].

    A wave w along what is undelivered, U, beside v, costs v + w/2 for each part of it. So w = 2
    (E/|U| - v), within the time constants ``SLOWLY_S`` and ``QUICKLY_S``.

    Parameters
    ----------
    undelivered
        Integral [sqrt(W) s], ``(..., dof)``.
    wave
        v [sqrt(W)].
    free_j
        Energy E that may be spent [J].
    """
    size = root(squared(undelivered))
    one_over = 1.0 / where(size > 0.0, size, 1.0)
    along = undelivered * one_over
    wanted = 2.0 * (free_j * one_over - dot(wave, along))
    wanted = minimum(wanted, size * (1.0 / QUICKLY_S))
    return along * maximum(wanted, size * (1.0 / SLOWLY_S))
