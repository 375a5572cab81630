# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What had happened by the instants at which a budget is drawn up."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array
from pmwvc_core.plant.motion import motion
from pmwvc_core.traces import UserTraces

# Gauss-Legendre: exact for the square of a velocity that is a polynomial up to the third degree.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)
Sums = dict[str, Array]  # running sums [J] at the instants, by part


class Series(NamedTuple):
    """A running sum [J] over time."""

    time_s: Array
    sums: Array


class AtFrames(NamedTuple):
    """Running sums at times of their own: the ends of a master's frames."""

    time_s: Array
    sums: Sums


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


def speeds(mass: float, damping: float, period_s: float, xd: Array, force: Array) -> list[Array]:
    """Return the velocities at the nodes of a period that starts with ``xd`` under a force."""
    return [
        np.asarray(motion(mass, damping, 0.5 * (1.0 + node) * period_s).advance(0.0, xd, force)[1])
        for node in NODES
    ]


def sum_of(sums: list[Array]) -> Array:
    """Return the sum of several energies over time."""
    return np.asarray(np.sum(sums, axis=0), dtype=float)
