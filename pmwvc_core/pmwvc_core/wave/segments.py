# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The segments of a wave that have arrived, in the time of their sender.

A segment is the integral dU of a wave over a duration dt. Its reserve, |dU|^2/(2 dt), is the
energy of its smoothest wave. Integral and reserve are read at any time, also within a segment.

Equations: docs/theory.md 17.1.
"""

from bisect import bisect_right
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array, Value, squared
from pmwvc_core.state import Stateful

ROUNDING_S = 1e-9  # of times


class Segments(Stateful):
    """See the module. Times, integrals and reserves are those since the first segment kept."""

    SIGNALS = "_integrals"
    MEMORY = "end_s reserve _ends_s _reserves"

    def __init__(self) -> None:
        self._ends_s = [0.0]
        self._integrals: list[Value] = [0.0]  # at these ends [sqrt(W) s]
        self._reserves: list[Value] = [0.0]  # likewise [J]
        self._take_ends()

    def _take_ends(self) -> None:
        self.end_s: float = self._ends_s[-1]  # at which the newest one ends [s]
        self.reserve: Value = self._reserves[-1]  # up to there [J]

    def __bool__(self) -> bool:
        return self.end_s > 0.0

    @property
    def integral(self) -> Value:
        """Integral up to there [sqrt(W) s]."""
        return self._integrals[-1]

    def add(self, integral: Value, duration_s: float) -> None:
        """Append a segment: its integral [sqrt(W) s], its duration > 0 [s]."""
        self._ends_s.append(self._ends_s[-1] + duration_s)
        self._integrals.append(self._integrals[-1] + integral)
        self._reserves.append(self._reserves[-1] + squared(integral) * (0.5 / duration_s))
        self._take_ends()

    def at(self, time_s: Value) -> tuple[Value, Value]:
        """Return integral and reserve up to a time."""
        ends, integrals, reserves = self._ends_s, self._integrals, self._reserves
        if isinstance(time_s, np.ndarray):
            times = np.array(ends)
            index = np.clip(np.searchsorted(times, time_s, side="right"), 1, len(ends) - 1)
            i = int(index.flat[0])
            if (index != i).any():  # seldom: runs within several segments
                each = (time_s - times[index - 1]) / (times[index] - times[index - 1])
                return _between(integrals, index, each), _between(reserves, index, each)
        else:
            i = min(bisect_right(ends, time_s), len(ends) - 1)
        ratio = (time_s - ends[i - 1]) / (ends[i] - ends[i - 1])
        before, needed = integrals[i - 1], reserves[i - 1]
        return before + (integrals[i] - before) * ratio, needed + (reserves[i] - needed) * ratio

    def forget(self, played_s: Value) -> tuple[float, Value, Value]:
        """Drop the segments that every run has played; the rest begins at zero.

        Returns
        -------
        tuple
            By how much time, integral and reserve are less from here on.
        """
        first = float(np.min(played_s)) if isinstance(played_s, np.ndarray) else played_s
        done = bisect_right(self._ends_s, first + ROUNDING_S) - 1
        if done < 1:
            return 0.0, 0.0, 0.0
        less = self._ends_s[done], self._integrals[done], self._reserves[done]
        self._ends_s = [each - less[0] for each in self._ends_s[done:]]
        self._integrals = [each - less[1] for each in self._integrals[done:]]
        self._reserves = [each - less[2] for each in self._reserves[done:]]
        self._take_ends()
        return less


def _between(values: list[Any], index: np.typing.NDArray[np.intp], ratio: Array) -> Array:
    """Interpolate values at the ends of segments, each run at its own time."""
    stacked = np.stack(np.broadcast_arrays(*values, ratio)[:-1])
    at = np.broadcast_to(index, stacked.shape[1:])[None]
    before = np.take_along_axis(stacked, at - 1, axis=0)[0]
    after = np.take_along_axis(stacked, at, axis=0)[0]
    found: Array = before + (after - before) * ratio
    return found
