# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The segments of a wave that a playout has at hand: its integral, and the reserve of energy that
its smoothest wave takes, where each of them ends.

Times are those of the sender, since the first segment kept began.
"""

from bisect import bisect_right
from typing import Any

import numpy as np

from pmwvc_core.numeric import Value, squared
from pmwvc_core.state import Stateful

ROUNDING_S = 1e-9  # of times


class Segments(Stateful):
    """See the module. Floats for one axis and one run, else arrays ``(..., dof)``.

    Attributes
    ----------
    end_s
        Where the newest segment ends; zero before the first [s].
    reserve_j
        Up to there [J].
    lasted_s
        Duration of the newest segment [s].
    integrals, reserves
        Up to the beginning of the first segment, and to the end of each [sqrt(W) s], [J].
    """

    SIGNALS = "integrals"
    MEMORY = "end_s reserve_j lasted_s reserves _ends_s"

    def __init__(self) -> None:
        self.end_s = self.lasted_s = 0.0
        self.reserve_j: Value = 0.0
        self._ends_s = [0.0]
        self.integrals: list[Value] = [0.0]
        self.reserves: list[Value] = [0.0]

    def add(self, integral: Value, duration_s: float) -> None:
        """Take in a segment behind those there are.

        Parameters
        ----------
        integral
            Of its wave [sqrt(W) s].
        duration_s
            Time that it stands for [s].
        """
        self.end_s = self.end_s + duration_s
        self.reserve_j = self.reserve_j + squared(integral) * (0.5 / duration_s)
        self._ends_s.append(self.end_s)
        self.integrals.append(self.integrals[-1] + integral)
        self.reserves.append(self.reserve_j)
        self.lasted_s = duration_s

    def place(self, time_s: Value) -> tuple[Any, Any]:
        """Return in which segment a time lies, from 1, and how far through it; in a batch of each
        run where they differ.
        """
        ends = self._ends_s
        if isinstance(time_s, np.ndarray):
            times = np.array(ends)
            index = np.clip(np.searchsorted(times, time_s, side="right"), 1, len(ends) - 1)
            i = int(index.flat[0])
            if (index != i).any():  # seldom: runs within several segments
                return index, (time_s - times[index - 1]) / (times[index] - times[index - 1])
        else:
            i = min(bisect_right(ends, time_s), len(ends) - 1)
        return i, (time_s - ends[i - 1]) / (ends[i] - ends[i - 1])

    def played(self, time_s: Value) -> int:
        """Return how many segments every run has played."""
        first = float(np.min(time_s)) if isinstance(time_s, np.ndarray) else time_s
        return max(bisect_right(self._ends_s, first + ROUNDING_S) - 1, 0)

    def forget(self, count: int) -> float:
        """Drop the first segments; the rest begins at zero. Return the time that goes with
        them [s].
        """
        time_s = self._ends_s[count]
        columns: tuple[list[Any], ...] = (self._ends_s, self.integrals, self.reserves)
        for kept in columns:
            gone = kept[count]
            del kept[:count]
            for place, each in enumerate(kept):
                kept[place] = each - gone
        self.end_s, self.reserve_j = self._ends_s[-1], self.reserves[-1]
        return time_s
