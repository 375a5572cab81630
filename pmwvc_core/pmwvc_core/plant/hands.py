# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands by name, at the beginning of their time (state and parameters of the laws), and the files
of those that are recorded: CSV or other text, or NumPy ``.npy``.

How a column is named (several are separated by commas): by its name in the header line of a text,
or by its number, counted from 0. Columns of text are separated by comma, semicolon, tab or blanks;
lines that begin with ``#`` are skipped. Without a name a single column of data is taken.

From the times it was recorded at to the ticks it is played at: a recording faster than the ticks
is low-passed at even times (median interval), forwards and backwards (no lag): Butterworth, order
8, -6 dB at 0.4 of the tick rate. Then monotone cubic interpolation (PCHIP: no overshoot,
continuous slope) at the ticks.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.numeric import Array
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.plant import forces, remote_hand
from pmwvc_core.plant.forces import task_of
from pmwvc_core.plant.hand import Place, RecordedHand, recorded_motion, task_hand

EDGE = 0.4  # of the tick rate: where the low-pass has -3 dB each way
ORDER = 8
Made = tuple[Any, Any]  # state and parameters


def make_hand(params: OperatorParams, task: TaskParams, at: Place) -> Made:
    """Return the hand that ``params.kind`` names; else ParameterError or RecordingError."""
    if params.is_hand:
        return task_hand(params, task, at)
    if params.is_remote:
        pressed = at.along(at.side * (at.half_width_m - params.squeeze / params.remote.stiffness))
        every = max(1, round(remote_hand.POINTER_S / at.tick_s))
        p, the_task = remote_hand.remote_params(params, at.tick_s), task_of(task, at.axes)
        pointer = remote_hand.PointerParams(p, the_task, at.start, pressed, every)
        return remote_hand.TaskHand(remote_hand.resting_remote(at.start), 0), pointer
    if params.is_recorded:
        recording = load_recording(params, tick_s=at.tick_s, dof=at.axes)
        if params.answers:
            return RecordedHand(0), recorded_motion(params, recording, at.start, at.tick_s)
        force = forces.recorded_params(recording, at.axes, params.repeat, False)
        return forces.RecordedForce(0), force
    amplitude = 0.0 if params.kind == "none" else params.force
    last_hz = params.frequency_end_hz if params.is_chirp else params.frequency_hz
    swings = params.is_sinusoid or params.is_chirp
    return forces.GivenForce(0), forces.ForceParams(
        at.along(amplitude), swings, at.tick_s, params.frequency_hz, last_hz, params.sweep_s
    )


def load_recording(params: OperatorParams, *, tick_s: float, dof: int) -> Array:
    """Return a recording at the ticks, ``(ticks, 1 or dof)`` [N or m]; else RecordingError."""
    file = params.file
    values, times = read_columns(params, dof=dof)
    if len(values) < 2:
        raise RecordingError(f"{file}: {len(values)} rows; a recording needs at least 2")
    broken = ~(np.isfinite(values).all(axis=1) & np.isfinite(times))
    if broken.any():
        raise RecordingError(
            f"{file}: {int(broken.sum())} rows hold a value that is not a finite number, the "
            f"first is row {int(broken.argmax())} (from 0); repair the file"
        )
    if (np.diff(times) <= 0.0).any():
        row = int((np.diff(times) <= 0.0).argmax()) + 1
        raise RecordingError(f"{file}: {params.time_column} does not rise at row {row} (from 0)")
    signal = params.scale * resample(values, times, tick_s=tick_s) + params.offset
    return fade(signal, fade_s=params.fade_s, tick_s=tick_s)


def read_columns(params: OperatorParams, *, dof: int) -> tuple[Array, Array]:
    """Return columns ``(rows, 1 or dof)`` and times [s] of a file; else RecordingError."""
    file = Path(params.file).expanduser()
    if not params.file:
        raise RecordingError("operator.file is empty: name the CSV or NPY file to play")
    if not file.is_file():
        raise RecordingError(f"{params.file}: no such file (looked in {Path.cwd()})")
    names, table = _table_of(file)
    wanted = [name.strip() for name in params.columns.split(",") if name.strip()]
    if not wanted:
        wanted = [name for name in names if name != params.time_column]
        if len(wanted) != 1:
            raise RecordingError(
                f"{file}: operator.columns is empty, and there is more than one column: "
                f"choose from {', '.join(names)}"
            )
    values = table[:, [_place(file, names, name) for name in wanted]]
    if len(wanted) not in (1, dof):
        raise RecordingError(
            f"{params.file}: operator.columns = {params.columns!r} are {len(wanted)} columns for "
            f"{dof} axes; give one column (it acts along the first axis) or one per axis"
        )
    if params.time_column:
        return values, table[:, _place(file, names, params.time_column)]
    return values, np.arange(len(values)) / params.rate_hz


def _table_of(file: Path) -> tuple[list[str], Array]:
    """Return the names of the columns of a file, and its rows; NaN is what is no number."""
    if file.suffix == ".npy":
        try:
            table = np.load(file, allow_pickle=False).astype(float)
            table = table.reshape(len(table), -1)
        except (ValueError, TypeError, EOFError) as error:
            raise RecordingError(f"{file}: no array of numbers: {error}") from error
        return [str(number) for number in range(table.shape[1])], table
    try:
        lines = file.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise RecordingError(f"{file}: not text ({error}); save it as UTF-8") from error
    lines = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise RecordingError(f"{file}: empty")
    separator = next((mark for mark in (";", "\t", ",") if mark in lines[0]), None)
    try:
        table = np.genfromtxt(lines, delimiter=separator, ndmin=2)
    except ValueError as error:  # rows of different lengths
        raise RecordingError(f"{file}: {error}; repair the file") from error
    if np.isnan(table[0]).all():
        return [cell.strip(' "') for cell in lines[0].split(separator)], table[1:]
    return [str(number) for number in range(table.shape[1])], table


def _place(file: Path, names: Sequence[str], name: str) -> int:
    """Return the number of a column, given by its name or its number."""
    if name in names:
        return names.index(name)
    if name.isdecimal() and int(name) < len(names):
        return int(name)
    raise RecordingError(
        f"{file}: no column {name!r}; there are {', '.join(names)}, "
        f"or by number 0 to {len(names) - 1}"
    )


def resample(values: Array, times: Array, *, tick_s: float) -> Array:
    """Return a signal ``(samples, columns)`` of rising times [s] at ``(ticks, columns)``."""
    # Importing it takes over a second, which nodes without a recording need not wait for.
    from scipy import interpolate, signal

    times, last_s = times - times[0], times[-1] - times[0]
    interval = float(np.median(np.diff(times)))
    if interval < tick_s * (1.0 - 1e-9):
        even = interval * np.arange(round(times[-1] / interval) + 1)
        values, times = interpolate.PchipInterpolator(times, values)(even), even
        sos = signal.butter(ORDER, 2.0 * EDGE * interval / tick_s, output="sos")
        padding = min(len(values) - 1, round(10.0 * tick_s / interval * ORDER))
        values = signal.sosfiltfilt(sos, values, axis=0, padlen=padding)
    ticks = tick_s * np.arange(int(last_s / tick_s * (1.0 + 1e-12)) + 1)
    return np.asarray(interpolate.PchipInterpolator(times, values)(np.minimum(ticks, times[-1])))


def fade(values: Array, *, fade_s: float, tick_s: float) -> Array:
    """Return a signal led in from zero and out to zero by half cosines, at most its halves."""
    from scipy.signal.windows import tukey

    share = 2.0 * fade_s / tick_s / (len(values) - 1)
    return values * np.asarray(tukey(len(values), min(share, 1.0)))[:, np.newaxis]
