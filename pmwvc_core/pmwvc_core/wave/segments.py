# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The segments of a wave that a playout has at hand: its integral, and the reserve of energy that
its smoothest wave takes, up to any time, even within a segment.

Times are those of the sender, since the first segment kept began.
"""

from bisect import bisect_right

import numpy as np

from pmwvc_core.numeric import Value, between, squared
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
    """

    SIGNALS = "_integrals"
    MEMORY = "end_s reserve_j lasted_s _ends_s _reserves"

    def __init__(self) -> None:
        self.end_s = self.lasted_s = 0.0
        self.reserve_j: Value = 0.0
        self._ends_s = [0.0]
        self._integrals: list[Value] = [0.0]
        self._reserves: list[Value] = [0.0]

    @property
    def integral(self) -> Value:
        """Integral up to the end of the newest segment [sqrt(W) s]."""
        return self._integrals[-1]

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
        self._integrals.append(self.integral + integral)
        self._reserves.append(self.reserve_j)
        self.lasted_s = duration_s

    def at(self, time_s: Value) -> tuple[Value, Value]:
        """Return integral and reserve up to a time."""
        ends, integrals, reserves = self._ends_s, self._integrals, self._reserves
        if isinstance(time_s, np.ndarray):
            times = np.array(ends)
            index = np.clip(np.searchsorted(times, time_s, side="right"), 1, len(ends) - 1)
            i = int(index.flat[0])
            if (index != i).any():  # seldom: runs within several segments
                each = (time_s - times[index - 1]) / (times[index] - times[index - 1])
                return between(integrals, index, each), between(reserves, index, each)
        else:
            i = min(bisect_right(ends, time_s), len(ends) - 1)
        ratio = (time_s - ends[i - 1]) / (ends[i] - ends[i - 1])
        before, needed = integrals[i - 1], reserves[i - 1]
        return before + (integrals[i] - before) * ratio, needed + (reserves[i] - needed) * ratio

    def forget(self, played_s: Value) -> tuple[float, Value, Value]:
        """Drop the segments that every run has played; the rest begins at zero. Return time,
        integral and reserve that go with them.
        """
        first = float(np.min(played_s)) if isinstance(played_s, np.ndarray) else played_s
        done = bisect_right(self._ends_s, first + ROUNDING_S) - 1
        if done < 1:
            return 0.0, 0.0, 0.0
        time_s, integral = self._ends_s[done], self._integrals[done]
        reserve = self._reserves[done]
        self._ends_s = [each - time_s for each in self._ends_s[done:]]
        self._integrals = [each - integral for each in self._integrals[done:]]
        self._reserves = [each - reserve for each in self._reserves[done:]]
        self.end_s, self.reserve_j = self._ends_s[-1], self._reserves[-1]
        return time_s, integral, reserve
