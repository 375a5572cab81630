# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy that a device gave its hand while the loop of its master stood still.

A device without a watchdog of its own goes on with the last force that it was told. Where the hand
moves along it, the device gives out - F (x_after - x_before), before any law can answer: that is
energy of the stall, not of the channel. At the ports it counts like any other.
"""

from typing import NamedTuple

import numpy as np

from pmwvc_analysis.traces.stretches import skips
from pmwvc_analysis.traces.sums import UserSums
from pmwvc_core.numeric import Array
from pmwvc_core.plural import count
from pmwvc_core.traces import UserTraces


class StoodStill(NamedTuple):
    """A time in which a loop skipped ticks [s], and the energy that the force held gave [J]."""

    start_s: float
    lasted_s: float
    given_j: float


def stood_still(user: UserTraces) -> list[StoodStill]:
    """Return when a user's loop skipped ticks, and what its device gave out; what was not recorded
    is not known.
    """
    rows = skips(user)
    moved = user.x_m[rows + 1] - user.x_m[rows]
    given = -np.sum(user.f_applied[rows] * moved, axis=-1)
    lasted = (np.diff(user.tick)[rows] - 1) * user.tick_s
    starts = user.time_s[rows]
    return [StoodStill(*row) for row in np.stack([starts, lasted, given], axis=-1).tolist()]


def over_skips(sums: UserSums, energy: Array) -> Array:
    """Return how much a running sum [J] at the instants of a budget changed in the blocks in which
    the loop skipped ticks: the master's own sums are those of whole blocks.
    """
    user = sums.user
    rows, ends = skips(user), np.append(user.block_ends, len(user.time_s))
    first = np.concatenate([[0], ends])[np.searchsorted(ends, rows, side="right")]
    last = ends[np.searchsorted(ends, rows + 1, side="right")]
    until = sums.ticks[:, np.newaxis]
    since = np.concatenate([[[0]], until[:-1]])
    inside = np.any((until > first) & (since <= last), axis=-1)
    return np.cumsum(np.where(inside, np.diff(energy, prepend=0.0), 0.0))


def given_until(found: list[StoodStill], time_s: float) -> tuple[float, str]:
    """Return what the forces held gave out up to a time [J], and in words when that was."""
    own = [each for each in found if each.start_s <= time_s and each.given_j > 0.0]
    if not own:
        return 0.0, ""
    worst = max(own, key=lambda each: each.given_j)
    times = count(len(own), "time") if len(own) > 1 else "once"
    words = f"{times}, for {worst.lasted_s:.3f} s at {worst.start_s:.2f} s"
    return sum(each.given_j for each in own), words
