# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Signals noted row by row while a session runs, kept as arrays."""

import struct
from collections.abc import Mapping, Sequence

import numpy as np

from pmwvc_core.numeric import Array, Integers, Value

WAITING = 256  # most rows that wait: they are in a cache still


class Columns:
    """Several signals of one width; zero where nothing is noted.

    A row of numbers is only put aside; many of them become arrays together, which takes a fifth of
    the time of writing each number into an array.

    Parameters
    ----------
    names
        Of the signals, in the order in which a row brings them.
    rows, width
        Size of each.
    """

    def __init__(self, names: Sequence[str], *, rows: int, width: int) -> None:
        self._together = np.zeros((rows, len(names), width))
        self._number = {name: number for number, name in enumerate(names)}
        self._waiting: list[Value | Integers] = []
        self._indices: list[int] = []

    def write(self, indices: Sequence[int], values: Sequence[Value | Integers]) -> None:
        """Note rows, each at its index; the values of a row follow those of the one before."""
        _, names, width = self._together.shape
        if width > 1:  # at once: arrays may change later
            rows = np.array([np.broadcast_to(value, width) for value in values])
            self._together[list(indices)] = rows.reshape(len(indices), names, width)
            return
        if not all(isinstance(value, (float, int)) for value in values):  # of a plug-in
            values = [float(np.sum(value)) for value in values]
        self._waiting += values
        self._indices += indices
        if len(self._indices) >= WAITING:
            self._settle()

    def of(self, name: str) -> Array:
        """Return a signal ``(rows, width)``, a view."""
        self._settle()
        found: Array = self._together[:, self._number[name]]
        return found

    def _settle(self) -> None:
        if not self._indices:
            return
        packed = struct.pack(f"{len(self._waiting)}d", *self._waiting)
        rows = np.frombuffer(packed).reshape(len(self._indices), -1, 1)
        self._together[self._indices] = rows
        self._waiting.clear()
        self._indices.clear()


class Accounts:
    """Energies noted row by row, under names that are known only once they come; zero where
    nothing is noted. ``rows`` as for columns.
    """

    def __init__(self, *, rows: int) -> None:
        self._rows = rows
        self._by_names: dict[tuple[str, ...], Columns] = {}

    def write(self, row: int, energies: Mapping[str, Value]) -> None:
        """Note a row of energies [J]."""
        names = tuple(energies)
        columns = self._by_names.get(names)
        if columns is None:
            columns = self._by_names[names] = Columns(names, rows=self._rows, width=1)
        columns.write((row,), list(energies.values()))

    def of(self, rows: int) -> dict[str, Array]:
        """Return the first rows by name ``(rows,)``; nothing is noted after it."""
        found: dict[str, Array] = {}
        for names, columns in self._by_names.items():
            for name in names:
                noted = columns.of(name)[:rows, 0]
                found[name] = found[name] + noted if name in found else noted.copy()
        return found
