# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Signals noted row by row while a session runs, kept as arrays."""

import struct
from collections.abc import Mapping, Sequence

import numpy as np

from pmwvc_core.numeric import Array, Integers, Value

TRANSPOSED = 16384  # numbers transposed together: they fit into a cache
WAITING = 256  # most rows of plain numbers that wait: they are in a cache still


class Columns:
    """Several signals of one width; zero where nothing is noted.

    While running a row is one block of memory, afterwards a run is. A row of plain numbers is only
    put aside; many of them become arrays together, which takes a fifth of the time of writing each
    number into an array.

    Parameters
    ----------
    names
        Of the signals, in the order in which a row brings them.
    rows, runs, width
        Size of each.
    plain
        Whether all values are plain numbers: one run with one axis.
    """

    def __init__(
        self, names: Sequence[str], *, rows: int, runs: int, width: int, plain: bool
    ) -> None:
        self._plain = plain
        if plain:
            self._together = np.zeros((rows, len(names)))
            arrays = [each.reshape(rows, 1, 1) for each in self._together.T]
        else:
            arrays = [np.zeros((rows, runs, width)) for _ in names]
        self._by_row = dict(zip(names, arrays, strict=True))
        self._by_run: dict[str, Array] = {}
        self._in_order = arrays
        self._waiting: list[Value | Integers] = []
        self._indices: list[int] = []

    def write(self, indices: Sequence[int], values: Sequence[Value | Integers]) -> None:
        """Note rows, each at its index; the values of a row follow those of the one before."""
        if self._plain:
            self._waiting += values
            self._indices += indices
            if len(self._indices) >= WAITING:
                self._settle()
            return
        width = len(self._in_order)
        for number, index in enumerate(indices):
            row = values[number * width : (number + 1) * width]
            for array, value in zip(self._in_order, row, strict=True):
                array[index] = value

    def of(self, name: str, run: int) -> Array:
        """Return a signal of one run ``(rows, width)``, a view; nothing is noted after it."""
        if self._waiting:
            self._settle()
        self._in_order = []
        if name in self._by_row:
            self._by_run[name] = _transposed(self._by_row.pop(name))
        found: Array = self._by_run[name][run]
        return found

    def _settle(self) -> None:
        packed = struct.pack(f"{len(self._waiting)}d", *self._waiting)
        self._together[self._indices] = np.frombuffer(packed).reshape(len(self._indices), -1)
        self._waiting.clear()
        self._indices.clear()


class Accounts:
    """Energies noted row by row, under names that are known only once they come; zero where
    nothing is noted.

    Parameters
    ----------
    rows, runs, plain
        As for columns.
    """

    def __init__(self, *, rows: int, runs: int, plain: bool) -> None:
        self._rows, self._runs, self._plain = rows, runs, plain
        self._by_names: dict[tuple[str, ...], Columns] = {}

    def write(self, row: int, energies: Mapping[str, Value]) -> None:
        """Note a row of energies [J]."""
        names = tuple(energies)
        columns = self._by_names.get(names)
        if columns is None:
            size = {"rows": self._rows, "runs": self._runs, "width": 1}
            columns = self._by_names[names] = Columns(names, **size, plain=self._plain)
        columns.write((row,), list(energies.values()))

    def of(self, run: int, rows: int) -> dict[str, Array]:
        """Return the first rows of one run by name ``(rows,)``; nothing is noted after it."""
        found: dict[str, Array] = {}
        for names, columns in self._by_names.items():
            for name in names:
                noted = columns.of(name, run)[:rows, 0]
                found[name] = found[name] + noted if name in found else noted.copy()
        return found


def _transposed(by_row: Array) -> Array:
    """Return ``(rows, runs, width)`` as ``(runs, rows, width)``."""
    rows, runs, width = by_row.shape
    by_run = np.empty((runs, rows, width))
    some = max(1, TRANSPOSED // (runs * width))
    for first in range(0, rows, some):
        here = slice(first, first + some)
        by_run[:, here] = by_row[here].swapaxes(0, 1)
    return by_run
