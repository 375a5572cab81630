# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded delays: read from a text file, looked up by time, repeated in a loop."""

import bisect
import functools
import itertools
import math
import re
import statistics
from dataclasses import dataclass
from pathlib import Path

from pmwvc_core.errors import RecordingError

LONGEST_GAP_S = 0.2  # a longer interval between rows is a pause of the recording
UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
TIME_NAMES = ("pub_time", "time", "t")
DELAY_NAMES = ("delay", "rtt", "latency")


@dataclass(frozen=True)
class DelayTrace:
    """Delays over time; between two rows the earlier one holds, after the last it starts again."""

    time_ns: tuple[int, ...]  # of each row, from 0
    delay_ns: tuple[int, ...]
    length_ns: int  # time after which it starts again

    @functools.cached_property
    def longest_s(self) -> float:
        """Return the longest delay [s]."""
        return max(self.delay_ns) * 1e-9

    @functools.cached_property
    def mean_s(self) -> float:
        """Return the mean of the delay over time [s]."""
        held = zip(itertools.pairwise((*self.time_ns, self.length_ns)), self.delay_ns, strict=True)
        return sum((end - start) * delay for (start, end), delay in held) / self.length_ns * 1e-9

    def at(self, elapsed_ns: int) -> int:
        """Return the delay [ns] at a time since the beginning [ns]."""
        row = bisect.bisect_right(self.time_ns, elapsed_ns % self.length_ns) - 1
        return self.delay_ns[row]


@functools.lru_cache(maxsize=32)
def load_delay_trace(path: str, scale: float) -> DelayTrace:
    """Read a delay recording once.

    A text file, one row per measurement, columns separated by commas, semicolons or blanks. With a
    header line the columns are found by name: time is ``pub_time``, ``time`` or ``t``, in the unit
    the name carries (``time_ms``, ``pub_time(ms)``; seconds without); delay is ``delay``, ``rtt``
    or ``latency``. Without a header they are the first (in seconds) and the second. Other columns
    and lines that start with ``#`` are not read.

    Pauses (intervals above 0.2 s) are taken out: the segments are joined at the median interval,
    and so are the end and the beginning.

    Parameters
    ----------
    path
        The file.
    scale
        Seconds per unit of the delay column; half of it where the delay is a round trip and each
        direction gets half.

    Raises
    ------
    RecordingError
        If the file cannot be used, with the reason and the columns found.
    """
    rows = _rows(path)
    time_column, delay_column, unit_s, header = _columns(path, rows[0])
    time_s: list[float] = []
    delay_s: list[float] = []
    for number, row in enumerate(rows[header:], start=header + 1):
        try:
            time_s.append(float(row[time_column]) * unit_s)
            delay_s.append(float(row[delay_column]) * scale)
        except (ValueError, IndexError):
            raise RecordingError(
                f"{path}: row {number} has no number in column {time_column + 1} (time) "
                f"or {delay_column + 1} (delay): {' '.join(row)}"
            ) from None
    return _trace(path, time_s, delay_s)


def _rows(path: str) -> list[list[str]]:
    if not path:
        raise RecordingError("no file is named; jitter = trace needs one with times and delays")
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path}: not text ({error}); save it as UTF-8") from None
    except OSError as error:
        reason = error.strerror or error
        raise RecordingError(
            f"{path}: cannot be read as a delay trace: {reason} (looked in {Path.cwd()})"
        ) from None
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    if not lines:
        raise RecordingError(f"{path}: holds no row; a row is a time and a delay")
    mark = next((mark for mark in ",;" if mark in lines[0]), None)
    return [[cell.strip() for cell in line.split(mark)] for line in lines]


def _columns(path: str, first: list[str]) -> tuple[int, int, float, int]:
    """Return the columns of time and delay, the unit of time [s] and how many lines are header."""
    if not any(re.search("[A-DF-Za-df-z]", cell) for cell in first[:2]):
        return 0, 1, 1.0, 0
    named = [
        re.fullmatch(r"(.*?)(?:[\s_(\[]+(ns|us|ms|s)[)\]]?)?", cell.lower()) for cell in first
    ]
    names = [match.group(1) if match else "" for match in named]

    def find(wanted: tuple[str, ...]) -> int:
        for name in wanted:
            if name in names:
                return names.index(name)
        raise RecordingError(
            f"{path}: no column named {' or '.join(wanted)}; there are {', '.join(first)}"
        )

    time_column = find(TIME_NAMES)
    match = named[time_column]
    unit = match.group(2) if match else None
    return time_column, find(DELAY_NAMES), UNITS[unit or "s"], 1


def _trace(path: str, time_s: list[float], delay_s: list[float]) -> DelayTrace:
    steps = [after - before for before, after in itertools.pairwise(time_s)]
    if not steps:
        raise RecordingError(f"{path}: needs at least two rows")
    if not all(map(math.isfinite, time_s + delay_s)) or min(steps) < 0 or min(delay_s) < 0:
        raise RecordingError(f"{path}: times must not go back and delays must not be negative")
    usual = statistics.median(step for step in steps if step > 0) if any(steps) else 0.0
    if usual <= 0.0:
        raise RecordingError(f"{path}: all rows have the same time")
    times = [0]
    for step in steps:
        times.append(times[-1] + round((usual if step > LONGEST_GAP_S else step) * 1e9))
    return DelayTrace(
        tuple(times),
        tuple(round(delay * 1e9) for delay in delay_s),
        times[-1] + round(usual * 1e9),
    )
