# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The few operations that let one formula run on plain floats and on arrays ``(..., dof)``, whose
last axis is the degrees of freedom; a quantity per run has a last axis of length 1.
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Complex: TypeAlias = NDArray[np.complex128]
Flags: TypeAlias = NDArray[np.bool_]
Value: TypeAlias = float | Array
Flag: TypeAlias = bool | Flags

AXES = 6  # of a session in which handles turn: ends have orientations


def dot(left: Value, right: Value) -> Value:
    """Inner product over the axes, kept as a last axis of length 1 (a float on floats)."""
    product = left * right
    if type(product) is float:  # a third of the time of isinstance
        return product
    if isinstance(product, np.ndarray) and product.ndim and product.shape[-1] > 1:
        summed: Array = product.sum(axis=-1, keepdims=True)
        return summed
    return product


def squared(value: Value) -> Value:
    """Squared Euclidean length over the degrees of freedom."""
    return value * value if type(value) is float else dot(value, value)


def root(value: Value) -> Value:
    """Square root of a value that is not negative."""
    return math.sqrt(value) if isinstance(value, (float, int)) else np.sqrt(value)


def finite(value: Value) -> bool:
    """Tell whether every element is a finite number."""
    return math.isfinite(value) if type(value) is float else bool(np.isfinite(value).all())


def flatten(value: Value) -> Array:
    """Return the elements as a one-dimensional array (the form messages and traces hold)."""
    return np.atleast_1d(np.asarray(value, dtype=float)).ravel()
