# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Signals of users, floats or ``(..., dof)``, as arrays ``(users, ..., dof)``, and back."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array, Flag, Value
from pmwvc_core.state import Stateful
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance


class Rows(Stateful):
    """The form of one user's signal."""

    MEMORY = "shape _plain"

    def __init__(self) -> None:
        self.shape: tuple[int, ...] = (1,)
        self._plain = True  # one axis, one run: floats

    def fit(self, signal: Value) -> None:
        """Take the form of a signal."""
        self._plain = not isinstance(signal, np.ndarray)
        self.shape = np.shape(np.atleast_1d(signal))

    def of(self, values: Sequence[Value]) -> Array:
        """Return signals of users as one array."""
        return np.stack([np.broadcast_to(np.asarray(v, float), self.shape) for v in values])

    def matrices(self, impedances: Sequence[Impedance]) -> Array:
        """Return impedances of users as matrices ``(users, ..., dof, dof)``."""
        return np.stack([self._matrix(b) for b in impedances])

    def _matrix(self, b: Impedance) -> Array:
        dof = self.shape[-1]
        if isinstance(b, MatrixImpedance):
            return np.broadcast_to(b.matrix, (*self.shape, dof))
        number = np.broadcast_to(np.asarray(b, float), (*self.shape[:-1], 1))
        return np.asarray(number[..., np.newaxis] * np.eye(dof))

    def value(self, row: Array) -> Value:
        """Return one user's part of an array as a signal."""
        return float(row[0]) if self._plain else row

    def flag(self, row: Any) -> Flag:
        """Return one user's part of an array of flags."""
        return bool(row[0]) if self._plain else row
