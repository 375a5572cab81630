# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Signals noted row by row while a session runs, kept as arrays."""

from collections.abc import Sequence

import numpy as np

from pmwvc_core.numeric import Array, Value

AT_ONCE = 4096  # rows of plain numbers that wait before they become arrays


class Columns:
    """Several signals of one width, ``(rows, runs, width)`` each; zero where nothing is noted.

    A row of plain numbers is only put aside; many of them become arrays together, which takes a
    fifth of the time of writing each number into an array.

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
        if self._plain:
            self._together = np.zeros((rows, len(names)))
            arrays = [each.reshape(rows, 1, 1) for each in self._together.T]
        else:
            arrays = [np.zeros((rows, runs, width)) for _ in names]
        self._arrays = dict(zip(names, arrays, strict=True))
        self._in_order = arrays
        self._waiting: list[Sequence[Value]] = []
        self._places: list[int] = []

    def write(self, places: Sequence[int], rows: Sequence[Sequence[Value]]) -> None:
        """Note rows, each at its place."""
        if self._plain:
            self._waiting += rows
            self._places += places
            if len(self._waiting) >= AT_ONCE:
                self._settle()
            return
        for place, row in zip(places, rows, strict=True):
            for array, value in zip(self._in_order, row, strict=True):
                array[place] = value

    def __getitem__(self, name: str) -> Array:
        """Return a signal ``(rows, runs, width)``."""
        if self._waiting:
            self._settle()
        return self._arrays[name]

    def _settle(self) -> None:
        self._together[self._places] = self._waiting
        self._waiting.clear()
        self._places.clear()
