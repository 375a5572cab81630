# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded force or motion from a file: CSV or other text, or NumPy ``.npy``.

How a column is named (several are separated by commas):

* text: the name in the header line, or the number of the column, counted from 0; columns are
  separated by comma, semicolon, tab or blanks; lines that begin with ``#`` are skipped;
* NPY: the number of the column, counted from 0.

Without a name a file with a single column of data is taken as it is.
"""

from pathlib import Path

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.numeric import Array
from pmwvc_core.params import OperatorParams
from pmwvc_core.plant.resampling import fade, resample
from pmwvc_core.plant.tables import Table, read_npy, read_text


def load_recording(params: OperatorParams, *, tick_s: float, dof: int) -> Array:
    """Return the recording of an operator at the ticks of the force loop, ``(ticks, 1 or dof)``
    [N or m]; RecordingError saying which file, what it holds, and what to do.
    """
    values, times = read_columns(params, dof=dof)
    _check(params.file, values, times, params.time_column)
    signal = params.scale * resample(values, times, tick_s=tick_s) + params.offset
    return fade(signal, fade_s=params.fade_s, tick_s=tick_s)


def read_columns(params: OperatorParams, *, dof: int) -> tuple[Array, Array]:
    """Return the columns of an operator's file as they are, ``(rows, 1 or dof)``, and the times of
    the rows [s]; RecordingError where there is no such file, a column is not in it, or they are
    none of so many axes.
    """
    file = Path(params.file).expanduser()
    if not params.file:
        raise RecordingError("operator.file is empty: name the CSV or NPY file to play")
    if not file.is_file():
        raise RecordingError(f"{params.file}: no such file (looked in {Path.cwd()})")
    source = _open(file)
    names = [name.strip() for name in params.columns.split(",") if name.strip()]
    values = source.data(names, params.time_column)
    count = values.shape[1]
    if count not in (1, dof):
        raise RecordingError(
            f"{params.file}: operator.columns = {params.columns!r} are {count} columns for {dof} "
            "axes; give one column (it acts along the first axis) or one per axis"
        )
    if params.time_column:
        return values, source.column(params.time_column)[:, 0]
    return values, np.arange(len(values)) / params.rate_hz


def _check(file: str, values: Array, times: Array, time_column: str) -> None:
    """Refuse what cannot be played."""
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


def _open(file: Path) -> Table:
    """Return the file's columns; its suffix decides the kind."""
    suffix = file.suffix.lower()
    if suffix == ".npy":
        return read_npy(file)
    if suffix in (".csv", ".txt", ".tsv", ".dat"):
        return read_text(file)
    raise RecordingError(f"{file}: unknown kind {suffix!r}; use .csv, .txt, .tsv, .dat, .npy")
