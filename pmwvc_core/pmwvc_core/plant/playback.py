# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded force or motion from a file: CSV or other text, MATLAB 5 ``.mat``, or NumPy ``.npy``.

How a column is named (several are separated by commas):

* text: the name in the header line, or the number of the column, counted from 0; columns are
  separated by comma, semicolon, tab or blanks; lines that begin with ``#`` are skipped;
* MAT: a variable, with fields and indices from 0 as in Python, ``scope.signals[1].values[:,0]``; a
  two-dimensional one brings all its columns;
* NPY: the number of the column, counted from 0.

Without a name a file with a single column of data is taken as it is.
"""

import re
from pathlib import Path

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.numeric import Array
from pmwvc_core.plant.matlab import MatlabFile
from pmwvc_core.plant.resampling import fade, resample
from pmwvc_core.plant.tables import Table, read_npy, read_text

_OUTSIDE_BRACKETS = re.compile(r",(?![^\[]*\])")


def load_recording(
    path: str | Path,
    *,
    columns: str,
    tick_s: float,
    time_column: str = "",
    rate_hz: float = 1000.0,
    scale: float = 1.0,
    offset: float = 0.0,
    fade_s: float = 0.0,
) -> Array:
    """Read columns of a file and bring them to the ticks of the force loop.

    Parameters
    ----------
    path
        CSV, MAT or NPY file, relative to the working directory.
    columns, time_column
        Columns of data, and the column with the time [s]; without one ``rate_hz`` holds.
    tick_s
        Period of the force loop [s].
    rate_hz
        Sample rate of a file without a time column [Hz].
    scale, offset
        SI value = scale * value + offset.
    fade_s
        Time over which the signal is led in from zero and out to zero [s].

    Returns
    -------
    Array
        ``(ticks, columns)`` [N or m].

    Raises
    ------
    RecordingError
        Saying which file, what it holds, and what to do.
    """
    file = Path(path)
    values, times = read_columns(path, columns, time_column, rate_hz=rate_hz)
    _check(file, values, times, time_column)
    return fade(
        scale * resample(values, times, tick_s=tick_s) + offset, fade_s=fade_s, tick_s=tick_s
    )


def read_columns(
    path: str | Path, columns: str, time_column: str, *, rate_hz: float = 1000.0
) -> tuple[Array, Array]:
    """Return columns of a file as they are, ``(rows, columns)``, and the times of the rows [s].

    Parameters
    ----------
    path, columns, time_column, rate_hz
        As for :func:`load_recording`.

    Raises
    ------
    RecordingError
        If there is no such file, or a column is not in it.
    """
    file = Path(path).expanduser()
    if not str(path):
        raise RecordingError("operator.file is empty: name the CSV, MAT or NPY file to play")
    if not file.is_file():
        raise RecordingError(f"{path}: no such file (looked in {Path.cwd()})")
    source = _open(file)
    names = [name.strip() for name in _OUTSIDE_BRACKETS.split(columns) if name.strip()]
    values = source.data(names, time_column)
    if time_column:
        return values, source.column(time_column)[:, 0]
    return values, np.arange(len(values)) / rate_hz


def _check(file: Path, values: Array, times: Array, time_column: str) -> None:
    """Refuse what cannot be played."""
    if len(values) != len(times):
        raise RecordingError(
            f"{file}: {time_column} has {len(times)} rows, the data {len(values)}; "
            "choose columns of equal length"
        )
    if len(values) < 2:
        raise RecordingError(f"{file}: {len(values)} rows; a recording needs at least 2")
    broken = ~(np.isfinite(values).all(axis=1) & np.isfinite(times))
    if broken.any():
        raise RecordingError(
            f"{file}: {int(broken.sum())} rows hold a value that is not a finite number, the "
            f"first is row {int(broken.argmax())} (from 0); repair or cut the file"
        )
    if (np.diff(times) <= 0.0).any():
        row = int((np.diff(times) <= 0.0).argmax()) + 1
        raise RecordingError(f"{file}: {time_column} does not rise at row {row} (from 0)")


def _open(file: Path) -> Table | MatlabFile:
    """Return the file's columns; its suffix decides the kind."""
    suffix = file.suffix.lower()
    if suffix == ".mat":
        return MatlabFile(file)
    if suffix == ".npy":
        return read_npy(file)
    if suffix in (".csv", ".txt", ".tsv", ".dat"):
        return read_text(file)
    raise RecordingError(
        f"{file}: unknown kind {suffix!r}; use .csv, .txt, .tsv, .dat, .mat, .npy"
    )
