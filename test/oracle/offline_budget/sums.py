# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Running sums of energy [J], brought to the instants at which a budget is drawn up."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.traces.holes import stretches
from pmwvc_core.numeric import Array
from pmwvc_core.traces import SessionTraces, UserTraces

Sums = dict[str, Array]  # running sums [J] at the instants, by part


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


def sum_of(sums: list[Array]) -> Array:
    """Return the sum of several energies over time."""
    return np.asarray(np.sum(sums, axis=0), dtype=float)


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


@dataclass(frozen=True)
class Clock:
    """The instants at which a budget is drawn up, and what had happened by then."""

    time_s: Array  # (instant,)
    steps: NDArray[np.intp]  # (instant,) rows of the server's steps

    def ticks_before(self, user: UserTraces) -> NDArray[np.intp]:
        """Return how many recorded ticks had run; never all, so that the next one's start is
        known.
        """
        ran = np.maximum.accumulate(user.time_s + user.lateness_s)
        count = np.searchsorted(ran, self.time_s - 0.001 * user.tick_s)
        return np.minimum(count, len(user.time_s) - 1)

    def at_ticks(self, user: UserTraces, per_tick: Array) -> Array:
        """Return the running sum of something per tick."""
        return np.concatenate([[0.0], np.cumsum(per_tick)])[self.ticks_before(user)]

    def of_ticks(self, user: UserTraces, sums: Array) -> Array:
        """Return what already is a running sum, after each tick."""
        return np.concatenate([[0.0], sums])[self.ticks_before(user)]

    def of_blocks(self, user: UserTraces, sums: Array, frame_s: float, *, after_s: float) -> Array:
        """Return a sum the master kept, which grows ``after_s`` into each of its frames."""
        ends = user.block_time_s
        starts = np.maximum(ends - frame_s, np.concatenate([[-np.inf], ends[:-1]]))
        first = np.searchsorted(user.time_s, starts + after_s - 0.5 * user.tick_s)
        ran = np.maximum.accumulate(user.time_s + user.lateness_s)
        count = np.searchsorted(
            ran[np.minimum(first, len(ran) - 1)], self.time_s + 0.001 * user.tick_s
        )
        return np.concatenate([[0.0], sums])[count]


def evenly(clock: Clock, user: UserTraces, sums: Sums) -> Sums:
    """Return sums that are known at the ends of frames at the instants of a budget."""
    ends = np.concatenate([[0.0], user.block_time_s])
    return {
        name: np.interp(clock.time_s, ends, np.concatenate([[0.0], each]))
        for name, each in sums.items()
    }


def clock_of(traces: SessionTraces, users: list[UserTraces]) -> Clock:
    """Return the times of the server's steps of which every user's record tells, up to the last
    one that every user's ticks reach.
    """
    assert traces.server is not None
    times = traces.server.time_s
    lateness = traces.metadata.get("server_lateness_s")
    if lateness is not None and len(lateness) == len(times):
        times = times + lateness
    end = min(float(user.time_s[-1] + user.lateness_s[-1]) for user in users)
    known = times <= end + 1e-9
    for user in users:
        stays = stretches(user, traces.server, traces)
        known &= stays.known(times) & (times < stays.first_s)
    rows = np.flatnonzero(known) if known.any() else np.zeros(1, dtype=np.intp)
    return Clock(times[rows], rows)
