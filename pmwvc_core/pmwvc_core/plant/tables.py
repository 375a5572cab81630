# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Columns of a text file (CSV and the like) or of a NumPy array, by name or number."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.numeric import Array


class Table:
    """Named or numbered columns of text or of an array."""

    def __init__(self, file: Path, names: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
        self.file, self.names, self.rows = file, list(names), rows

    def data(self, names: Sequence[str], time_column: str) -> Array:
        """Return the columns named, or the only one there is."""
        if not names:
            names = [name for name in self.names if name != time_column]
            if len(names) != 1:
                raise RecordingError(
                    f"{self.file}: operator.columns is empty, and there is more than one column: "
                    f"choose from {', '.join(self.names)}"
                )
        return np.hstack([self.column(name) for name in names])

    def column(self, name: str) -> Array:
        """Return one column ``(rows, 1)``."""
        index = self._index(name)
        values = np.empty((len(self.rows), 1))
        for number, row in enumerate(self.rows):
            try:
                values[number] = row[index]
            except (IndexError, ValueError) as error:
                text = row[index] if index < len(row) else "nothing"
                raise RecordingError(
                    f"{self.file}: row {number} (from 0) of column {name} holds {text!r}, not a "
                    "number; choose another column or repair the file"
                ) from error
        return values

    def _index(self, name: str) -> int:
        if name in self.names:
            return self.names.index(name)
        if name.isdecimal() and int(name) < len(self.names):
            return int(name)
        raise RecordingError(
            f"{self.file}: no column {name!r}; there are {', '.join(self.names)}, "
            f"or by number 0 to {len(self.names) - 1}"
        )


def read_npy(file: Path) -> Table:
    """Read an array ``(rows,)`` or ``(rows, columns)``."""
    try:
        array = np.load(file, allow_pickle=False)
    except (ValueError, EOFError) as error:
        raise RecordingError(f"{file}: not a NumPy array of numbers ({error})") from error
    if array.dtype.kind not in "iuf" or array.ndim not in (1, 2):
        raise RecordingError(
            f"{file}: {array.dtype} of shape {array.shape}; save numbers as (rows,) or "
            "(rows, columns)"
        )
    rows = array.reshape(len(array), -1)
    return Table(file, [str(number) for number in range(rows.shape[1])], rows)


def read_text(file: Path) -> Table:
    """Read text with or without a line of names."""
    try:
        lines = file.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise RecordingError(f"{file}: not text ({error}); save it as UTF-8") from error
    lines = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise RecordingError(f"{file}: empty")
    separator = next((mark for mark in (";", "\t", ",") if mark in lines[0]), None)
    rows = [[cell.strip() for cell in line.split(separator)] for line in lines]
    if any(_number(cell) for cell in rows[0]):
        return Table(file, [str(number) for number in range(len(rows[0]))], rows)
    return Table(file, [cell.strip('"') for cell in rows[0]], rows[1:])


def _number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
