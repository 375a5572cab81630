# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded delays and losses: looked up by time, repeated in a loop."""

import bisect
import functools
import itertools
import statistics
from dataclasses import dataclass

from pmwvc_core.errors import RecordingError
from pmwvc_core.network.trace_formats import Rows, read_rows

LONGEST_GAP_S = 0.2  # a longer interval between rows is a pause of the recording
LOST = -1  # in place of a delay


@dataclass(frozen=True)
class DelayTrace:
    """Delays over time; between two rows the earlier one holds, after the last it starts again."""

    time_ns: tuple[int, ...]  # of each row, from 0
    delay_ns: tuple[int, ...]  # LOST where a packet was lost
    length_ns: int  # time after which it starts again

    @functools.cached_property
    def delays_s(self) -> tuple[float, ...]:
        """Return the delays [s] in their order of size, without the losses."""
        return tuple(sorted(delay * 1e-9 for delay in self.delay_ns if delay != LOST))

    @functools.cached_property
    def longest_s(self) -> float:
        """Return the longest delay [s]."""
        return self.delays_s[-1]

    @functools.cached_property
    def mean_s(self) -> float:
        """Return the mean of the delay over time [s], where nothing was lost."""
        held = [(length, delay) for length, delay in self._held if delay != LOST]
        return sum(n * delay for n, delay in held) / sum(n for n, _ in held) * 1e-9

    @functools.cached_property
    def lost_ratio(self) -> float:
        """Return the part of the time during which packets were lost."""
        return sum(length for length, delay in self._held if delay == LOST) / self.length_ns

    @functools.cached_property
    def _held(self) -> list[tuple[int, int]]:
        """Duration and delay of every row [ns]."""
        edges = itertools.pairwise((*self.time_ns, self.length_ns))
        return [(b - a, delay) for (a, b), delay in zip(edges, self.delay_ns, strict=True)]

    def at(self, elapsed_ns: int) -> int:
        """Return the delay [ns] at a time since the beginning [ns]."""
        row = bisect.bisect_right(self.time_ns, elapsed_ns % self.length_ns) - 1
        return self.delay_ns[row]

    def lost(self, elapsed_ns: int) -> bool:
        """Tell whether a packet sent at a time since the beginning [ns] was lost."""
        return self.at(elapsed_ns) == LOST


@functools.lru_cache(maxsize=32)
def load_delay_trace(path: str, scale: float, column: str = "") -> DelayTrace:
    """Read a delay recording once; formats: :mod:`pmwvc_core.network.trace_formats`.

    Pauses (intervals above 0.2 s, unless they are usual) are taken out: the segments are joined at
    the median interval, and so are the end and the beginning. RecordingError where the file cannot
    be used, with the reason and the columns found.

    ``scale`` is in seconds per unit of the delay column, or half of it where the delay is a round
    trip and each direction gets half; of IRTT, whose units are known, a factor. ``column`` is the
    name of the column of delays; empty: the usual ones.
    """
    rows = read_rows(path, column)
    delays = [None if delay is None else delay * scale for delay in rows.delay]
    return _trace(path, rows, delays)


def _trace(path: str, rows: Rows, delays_s: list[float | None]) -> DelayTrace:
    steps = [after - before for before, after in itertools.pairwise(rows.time_s)]
    if not steps:
        raise RecordingError(f"{path}: needs at least two rows")
    back = next((n for n, step in enumerate(steps, start=2) if not step >= 0.0), None)
    if back is not None:
        before, after = rows.time_s[back - 2 : back]
        raise RecordingError(
            f"{path}: times must not go back: {after:.9g} s in data row {back} after "
            f"{before:.9g} s"
        )
    for n, delay in enumerate(delays_s, start=1):
        if delay is not None and not 0.0 <= delay <= 60.0:
            raise RecordingError(
                f"{path}: delay of {delay:.9g} s in data row {n}: delays must not be negative nor "
                "above 60 s (trace_scale is the factor to seconds)"
            )
    if all(delay is None for delay in delays_s):
        raise RecordingError(f"{path}: every packet is lost; there is no delay in it")
    usual = statistics.median(step for step in steps if step > 0) if any(steps) else 0.0
    if usual <= 0.0:
        raise RecordingError(f"{path}: all rows have the same time")
    times = [0]
    for step in steps:
        times.append(times[-1] + round((usual if step > LONGEST_GAP_S else step) * 1e9))
    return DelayTrace(
        tuple(times),
        tuple(LOST if delay is None else round(delay * 1e9) for delay in delays_s),
        times[-1] + round(usual * 1e9),
    )
