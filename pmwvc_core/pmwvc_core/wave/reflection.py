# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A wave port closed with a force that follows the velocity of the same tick.

With F = F0 + G xd::

    xd = sqrt(2/b) u - F/b,   v = u - sqrt(2/b) F
    F = (F0 + sqrt(2/b) G u)/(1 + G/b)
    v = v0 + g u,   g = (b - G)/(b + G),   v0 = -sqrt(2/b) F0/(1 + G/b)

so |g| <= 1 for every G >= 0. With a matrix impedance the same in matrices, R = sqrt(2/B)::

    W = (1 + G B^-1)^-1,   F = W (F0 + G R u),   g = 1 - R W G R,   v0 = -R W F0

Equations: docs/theory.md 1.6.
"""

from typing import Any, Protocol

import numpy as np

from pmwvc_core.numeric import Array, Value
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance, times
from pmwvc_core.wave.transform import WavePort


class Reflection(Protocol):
    """The reflection of a port; G is one number, one per run ``(runs, 1)``, or per axis."""

    def of(self, f0: Value, slope: Value) -> tuple[Value, Any]:
        """Return v0 [sqrt(W)] and g."""

    def solve(self, u: Value, f0: Value, slope: Value) -> tuple[Value, Value, Value]:
        """Return F [N], xd [m/s] and v [sqrt(W)] for a wave u [sqrt(W)]."""


class _Scalar:
    def __init__(self, b: Value) -> None:
        self._port = WavePort(b)

    def of(self, f0: Value, slope: Value) -> tuple[Value, Value]:
        ratio = 1.0 + slope / self._port.b
        return self._port.v(0.0, f0) / ratio, 2.0 / ratio - 1.0

    def solve(self, u: Value, f0: Value, slope: Value) -> tuple[Value, Value, Value]:
        port = self._port
        f = (f0 + slope * port.free_velocity(u)) / (1.0 + slope / port.b)
        return f, port.velocity(u, f), port.v(u, f)


class _Matrix:
    def __init__(self, b: MatrixImpedance) -> None:
        self._b = b
        self._inverse = b.inverse().matrix
        self._ratio = (2.0 / b).root().matrix

    def of(self, f0: Value, slope: Value) -> tuple[Value, "MatrixGain"]:
        g, w = self._diagonal(slope), self._mobility(slope)
        gain = np.eye(len(self._ratio)) - self._ratio @ w @ g @ self._ratio
        return -times(self._ratio @ w, np.asarray(f0) + np.zeros(len(g))), MatrixGain(gain)

    def solve(self, u: Value, f0: Value, slope: Value) -> tuple[Value, Value, Value]:
        free = times(self._ratio, u)
        f = times(self._mobility(slope), f0 + slope * free)
        return f, free - times(self._inverse, f), u - times(self._ratio, f)

    def _diagonal(self, slope: Value) -> Array:
        """Return G as matrices ``(..., dof, dof)``."""
        diagonal: Array = np.asarray(slope)[..., np.newaxis] * np.eye(len(self._ratio))
        return diagonal

    def _mobility(self, slope: Value) -> Array:
        return _inverse(np.eye(len(self._ratio)) + self._diagonal(slope) @ self._inverse)


class MatrixGain:
    """A symmetric matrix where the gain of a wave may stand.

    ``matrix`` is ``(dof, dof)``, or ``(runs, dof, dof)``. Signals it acts on are arrays ``(...,
    dof)`` with ``dof`` > 1; arrays ``(runs, 1)`` are numbers, one per run.
    """

    __array_ufunc__ = None  # numpy leaves the operators to this class
    __slots__ = ("matrix",)

    def __init__(self, matrix: Array) -> None:
        self.matrix = matrix

    def __add__(self, number: Value) -> "MatrixGain":
        """Add a multiple of the identity."""
        return MatrixGain(self.matrix + _number(number) * np.eye(self.matrix.shape[-1]))

    __radd__ = __add__

    def __mul__(self, other: Value) -> Any:
        """Act on a signal, or scale by a number; zero is zero."""
        if isinstance(other, np.ndarray):
            if other.shape[-1] > 1:
                return times(self.matrix, other)
        elif not other:
            return 0.0
        return MatrixGain(_number(other) * self.matrix)

    __rmul__ = __mul__

    def __rtruediv__(self, signal: Array) -> Array:
        """Act on a signal with the inverse."""
        return times(_inverse(self.matrix), signal)


def reflection(b: Impedance) -> Reflection:
    """Return the reflection of a port of this impedance [N s/m]."""
    return _Matrix(b) if isinstance(b, MatrixImpedance) else _Scalar(b)


def _inverse(matrix: Array) -> Array:
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)


def _number(value: Value) -> Value:
    return value[..., np.newaxis] if isinstance(value, np.ndarray) else value
