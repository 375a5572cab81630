# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Formats of recorded delays: columns of text, the JSON of IRTT.

Columns: a text file, one row per packet, separated by commas, semicolons or blanks. With a header
line the columns are found by name: time is ``pub_time``, ``time``, ``t``, ``sent`` or
``send_time``, in the unit the name carries (``time_ms``, ``pub_time(ms)``; seconds without); delay
is ``delay``, ``rtt`` or ``latency``, or follows from ``received`` or ``receive_time``. Without a
header they are the first (in seconds) and the second. A delay or time of receipt that is empty or
``lost`` is a lost packet. Other columns and lines that start with ``#`` are not read.
"""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from pmwvc_core.errors import RecordingError

UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
TIME_NAMES = ("pub_time", "time", "t", "sent", "send_time")
DELAY_NAMES = ("delay", "rtt", "latency")
RECEIVED_NAMES = ("received", "receive_time")
LOST_TEXTS = ("", "lost", "-", "none", "null")


class Rows(NamedTuple):
    """Times [s] and delays in the unit of the file, None where a packet was lost."""

    time_s: list[float]
    delay: list[float | None]


def read_rows(path: str, column: str) -> Rows:
    """Read a recording of any format, with the name of the column of delays (empty: the usual
    ones); RecordingError with the reason where the file cannot be used.
    """
    text = _text(path)
    if text.lstrip().startswith("{"):
        return _irtt(path, text, column or "rtt")
    return _columns(path, text, column)


def _text(path: str) -> str:
    if not path:
        raise RecordingError("no file is named; jitter = trace needs one with times and delays")
    try:
        return Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path}: not text ({error}); save it as UTF-8") from None
    except OSError as error:
        reason = error.strerror or error
        raise RecordingError(
            f"{path}: cannot be read as a delay trace: {reason} (looked in {Path.cwd()})"
        ) from None


def _irtt(path: str, text: str, column: str) -> Rows:
    """Return the round trips of a file of IRTT; a packet lost on the other way only arrived."""
    try:
        trips = json.loads(text)["round_trips"]
        rows = [_trip(trip, column) for trip in trips]
    except (ValueError, KeyError, TypeError) as error:
        raise RecordingError(
            f"{path}: JSON, but not of IRTT ({type(error).__name__}: {error}); it must hold "
            "round_trips with timestamps.client.send and delay.rtt, send or receive [ns]"
        ) from None
    return Rows([time for time, _ in rows], [delay for _, delay in rows])


def _trip(trip: dict[str, Any], column: str) -> tuple[float, float | None]:
    sent = trip["timestamps"]["client"]["send"]
    time_ns = sent["monotonic"] if "monotonic" in sent else sent["wall"]
    lost = str(trip["lost"]).lower()
    arrived = lost == "false" or (column == "send" and lost == "true_down")
    delay = trip["delay"].get(column) if arrived else None
    if delay is None and lost == "false":
        raise KeyError(f"delay.{column}")
    return time_ns * 1e-9, None if delay is None else delay * 1e-9


def _columns(path: str, text: str, column: str) -> Rows:
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    if not lines:
        raise RecordingError(f"{path}: holds no row; a row is a time and a delay")
    mark = next((mark for mark in ",;" if mark in lines[0]), None)
    rows = [[cell.strip() for cell in line.split(mark)] for line in lines]
    header = any(
        re.search("[A-DF-Za-df-z]", cell) and cell.lower() not in LOST_TEXTS
        for cell in rows[0][:2]
    )
    layout = _layout(path, rows[0], column) if header else _Layout(0, 1, 1.0, received=False)
    found = list(_cells(path, rows, layout, int(header)))
    return Rows([time for time, _ in found], [delay for _, delay in found])


class _Layout(NamedTuple):
    time: int
    delay: int
    unit_s: float  # of time
    received: bool  # the second column is a time as well


def _cells(
    path: str, rows: list[list[str]], layout: _Layout, header: int
) -> Iterator[tuple[float, float | None]]:
    for number, row in enumerate(rows[header:], start=header + 1):
        try:
            time_s = float(row[layout.time]) * layout.unit_s
            lost = row[layout.delay].lower() in LOST_TEXTS
            delay = None if lost else float(row[layout.delay])
        except (ValueError, IndexError):
            raise RecordingError(
                f"{path}: row {number} has no number in column {layout.time + 1} (time) "
                f"or {layout.delay + 1} (delay): {' '.join(row)}"
            ) from None
        if delay is not None and layout.received:
            delay = delay * layout.unit_s - time_s
        yield time_s, delay


def _layout(path: str, first: list[str], column: str) -> _Layout:
    """Return the columns of time and delay by their names."""
    named = [
        re.fullmatch(r"(.*?)(?:[\s_(\[]+(ns|us|ms|s)[)\]]?)?", cell.lower()) for cell in first
    ]
    names = [match.group(1) if match else "" for match in named]

    def find(wanted: tuple[str, ...]) -> int | None:
        return next((names.index(name) for name in wanted if name in names), None)

    def missing(wanted: tuple[str, ...]) -> RecordingError:
        return RecordingError(
            f"{path}: no column named {' or '.join(wanted)}; there are {', '.join(first)}"
        )

    time = find(TIME_NAMES)
    if time is None:
        raise missing(TIME_NAMES)
    match = named[time]
    unit_s = UNITS[(match.group(2) if match else None) or "s"]
    wanted = (column.lower(),) if column else DELAY_NAMES
    delay, received = find(wanted), find(RECEIVED_NAMES) if not column else None
    if delay is None and received is None:
        raise missing(wanted)
    at = received if delay is None else delay
    return _Layout(time, at or 0, unit_s, received=delay is None)
