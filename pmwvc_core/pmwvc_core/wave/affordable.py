# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The part of a change of a wave that can be paid for."""

from pmwvc_core.numeric import Value, anywhere, dot, maximum, minimum, root, squared, where


def affordable(wave: Value, change: Value, power: Value) -> tuple[Value, Value]:
    """Return as much of a change of a wave as can be paid for, and what it costs.

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
