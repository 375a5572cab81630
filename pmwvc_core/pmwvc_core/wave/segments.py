# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The segments of a wave that a playout has in store: its integral, and the reserve of energy that
its smoothest wave takes, where each of them ends.

Times are those of the sender, since the first segment kept began.
"""

from bisect import bisect_right
from typing import Any

from pmwvc_core.numeric import Value, squared
from pmwvc_core.state import Stateful

ROUNDING_S = 1e-9  # of times


class Segments(Stateful):
    """See the module. Floats for one axis and one run, else arrays ``(..., dof)``.

    Attributes
    ----------
    end_s
        Where the newest segment ends; zero before the first [s].
    integrals, reserves
        Up to the beginning of the first segment, and to the end of each [sqrt(W) s], [J].
    """

    SIGNALS = "integrals"
    MEMORY = "reserves _ends_s"

    def __init__(self) -> None:
        self._ends_s = [0.0]
        self.integrals: list[Value] = [0.0]
        self.reserves: list[Value] = [0.0]

    @property
    def end_s(self) -> float:
        """Where the newest segment ends; zero before the first [s]."""
        return self._ends_s[-1]

    def add(self, integral: Value, duration_s: float) -> None:
        """Take in a segment behind those there are.

        Parameters
        ----------
        integral
            Of its wave [sqrt(W) s].
        duration_s
            Time that it stands for [s].
        """
        self._ends_s.append(self.end_s + duration_s)
        self.integrals.append(self.integrals[-1] + integral)
        self.reserves.append(self.reserves[-1] + squared(integral) * (0.5 / duration_s))

    def place(self, time_s: float) -> tuple[int, float]:
        """Return in which segment a time lies, from 1, and how far through it."""
        ends = self._ends_s
        i = max(min(bisect_right(ends, time_s), len(ends) - 1), 1)
        return i, (time_s - ends[i - 1]) / (ends[i] - ends[i - 1])

    def played(self, time_s: float) -> int:
        """Return how many segments end before a time."""
        return max(bisect_right(self._ends_s, time_s + ROUNDING_S) - 1, 0)

    def forget(self, count: int) -> None:
        """Drop the first segments; the rest begins at zero."""
        columns: tuple[list[Any], ...] = (self._ends_s, self.integrals, self.reserves)
        for kept in columns:
            first = kept[count]
            del kept[:count]
            for place, each in enumerate(kept):
                kept[place] = each - first
