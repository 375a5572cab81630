# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded delays and losses: looked up by time, repeated in a loop. Files: columns of text, one
row per packet, separated by commas, semicolons or blanks.

With a header time is ``pub_time``, ``time``, ``t``, ``sent`` or ``send_time``, in the unit the
name carries (``time_ms``, ``pub_time(ms)``; seconds without); delay is ``delay``, ``rtt`` or
``latency``, or follows from ``received`` or ``receive_time``. Without they are the first (in
seconds) and the second. An empty delay or ``lost`` is a lost packet; ``#`` begins a remark.
"""

import bisect
import functools
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.params import LinkParams

LONGEST_GAP_S = 0.2  # a longer interval between rows is a pause of the recording
LOST = -1  # in place of a delay
UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
TIME_NAMES = ("pub_time", "time", "t", "sent", "send_time")
DELAY_NAMES = ("delay", "rtt", "latency")
RECEIVED_NAMES = ("received", "receive_time")
LOST_TEXTS = ("", "lost", "-", "none", "null")

Row = tuple[float, float | None]  # time [s], delay in the unit of the file, None: lost


class DelayTrace(NamedTuple):
    """Delays over time; between two rows the earlier one holds, after the last it starts again."""

    time_ns: tuple[int, ...]  # of each row, from 0
    delay_ns: tuple[int, ...]  # LOST where a packet was lost
    length_ns: int  # time after which it starts again
    delays_s: tuple[float, ...]  # in their order of size, without the losses
    mean_s: float  # over time, where nothing was lost
    lost_ratio: float  # part of the time

    def at(self, elapsed_ns: int) -> int:
        """Return the delay [ns] at a time since the beginning [ns]; LOST where a packet was."""
        return self.delay_ns[bisect.bisect_right(self.time_ns, elapsed_ns % self.length_ns) - 1]


def recording_of(params: LinkParams) -> DelayTrace:
    """Return the recording that the settings of a link name; see :func:`load_delay_trace`."""
    return load_delay_trace(params.trace_file, params.trace_scale, params.trace_column)


@functools.lru_cache(maxsize=32)
def load_delay_trace(path: str, scale: float, column: str = "") -> DelayTrace:
    """Read a delay recording once; else RecordingError with the reason and the columns found.

    Pauses (above 0.2 s, unless usual) are taken out: segments are joined at the median interval,
    as are end and beginning. ``scale`` is in seconds per unit of the delay ``column`` (half of it
    for round trips); empty: the usual names.
    """
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
    rows = _columns(path, text, column)
    times_s = np.array([time_s for time_s, _ in rows])
    lost = np.array([delay is None for _, delay in rows])
    delays_s = scale * np.array([0.0 if delay is None else delay for _, delay in rows])
    steps = np.diff(times_s)
    if not len(steps):
        raise RecordingError(f"{path}: needs at least two rows")
    for n in np.flatnonzero(~(steps >= 0.0)):
        raise RecordingError(
            f"{path}: times must not go back: {times_s[n + 1]:.9g} s in data row {n + 2} after "
            f"{times_s[n]:.9g} s"
        )
    for n in np.flatnonzero(~((delays_s >= 0.0) & (delays_s <= 60.0))):
        raise RecordingError(
            f"{path}: delay of {delays_s[n]:.9g} s in data row {n + 1}: delays must not be "
            "negative nor above 60 s (trace_scale is the factor to seconds)"
        )
    if lost.all():
        raise RecordingError(f"{path}: every packet is lost; there is no delay in it")
    if not steps.any():
        raise RecordingError(f"{path}: all rows have the same time")
    usual = np.median(steps[steps > 0.0])
    lasts = np.rint(np.append(np.where(steps > LONGEST_GAP_S, usual, steps), usual) * 1e9)
    times = [0, *np.cumsum(lasts).astype(int).tolist()]
    length = times.pop()
    delays = np.where(lost, LOST, np.rint(delays_s * 1e9)).astype(int)
    known, held = delays[~lost], lasts[~lost]
    mean_s, lost_ratio = float(known @ held / held.sum()) * 1e-9, float(lasts[lost].sum() / length)
    delays_s = np.sort(known) * 1e-9
    columns = tuple(times), tuple(delays.tolist()), length, tuple(delays_s.tolist())
    return DelayTrace(*columns, mean_s, lost_ratio)


def _columns(path: str, text: str, column: str) -> list[Row]:
    lines = [line for each in text.splitlines() if (line := each.strip()) and line[0] != "#"]
    if not lines:
        raise RecordingError(f"{path}: holds no row; a row is a time and a delay")
    mark = next((mark for mark in ",;" if mark in lines[0]), None)
    rows = [[cell.strip() for cell in line.split(mark)] for line in lines]
    header = any(
        re.search("[A-DF-Za-df-z]", cell) and cell.lower() not in LOST_TEXTS
        for cell in rows[0][:2]
    )
    time_at, delay_at, unit_s, received = 0, 1, 1.0, False
    if header:
        time_at, delay_at, unit_s, received = _named(path, rows[0], column)
    found: list[Row] = []
    for number, row in enumerate(rows[header:], start=header + 1):
        try:
            time_s = float(row[time_at]) * unit_s
            lost = row[delay_at].lower() in LOST_TEXTS
            delay = None if lost else float(row[delay_at])
        except (ValueError, IndexError):
            raise RecordingError(
                f"{path}: row {number} has no number in column {time_at + 1} (time) "
                f"or {delay_at + 1} (delay): {' '.join(row)}"
            ) from None
        if delay is not None and received:
            delay = delay * unit_s - time_s
        found.append((time_s, delay))
    return found


def _named(path: str, first: list[str], column: str) -> tuple[int, int, float, bool]:
    """Return the columns of time and delay, the time's unit [s], and if delay is a time."""
    named: dict[str, tuple[int, float]] = {}
    for at, cell in enumerate(first):
        if match := re.fullmatch(r"(.*?)(?:[\s_(\[]+(ns|us|ms|s)[)\]]?)?", cell.lower()):
            named.setdefault(match.group(1), (at, UNITS[match.group(2) or "s"]))

    def find(wanted: tuple[str, ...], other: tuple[str, ...] = ()) -> tuple[int, float]:
        for name in (*wanted, *other):
            if name in named:
                return named[name]
        raise RecordingError(
            f"{path}: no column named {' or '.join(wanted)}; there are {', '.join(first)}"
        )

    time, unit_s = find(TIME_NAMES)
    wanted = (column.lower(),) if column else DELAY_NAMES
    delay, _ = find(wanted, () if column else RECEIVED_NAMES)
    return time, delay, unit_s, named.keys().isdisjoint(wanted)
