# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Running sums of energy over the rows of a trace."""

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.traces import UserTraces


def half_square(wave: Array) -> Array:
    """Return the power of a wave, |w|^2 / 2 [W], per row."""
    power: Array = np.sum(wave * wave, axis=-1) / 2.0
    return power


def running(sums: Array) -> Array:
    """Return sums that only grow, going on where a user that left and came back began at zero."""
    result = sums.copy()
    for row in np.flatnonzero(np.diff(sums) < 0.0) + 1:
        result[row:] += result[row - 1] - (result[row] - sums[row])
    return result


def anchored(user: UserTraces, per_tick: Array, at_block_ends: Array | None) -> Array:
    """Return the running sum after each tick [J].

    The sums that the master itself kept, at the ends of its blocks, hold; in between the ticks'
    own values are added. So a block that was not recorded leaves no hole in the energy.
    """
    sums: Array = np.cumsum(per_tick)
    if at_block_ends is None or not len(at_block_ends):
        return sums
    last = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s) - 1
    blocks = np.clip(np.searchsorted(last, np.arange(len(sums))), 0, len(last) - 1)
    ends = np.clip(last, 0, len(sums) - 1)
    return sums + (at_block_ends - sums[ends])[blocks]
