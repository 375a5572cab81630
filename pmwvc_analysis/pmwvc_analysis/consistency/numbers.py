# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Differences of recorded numbers beyond what rounding explains."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pmwvc_core.numeric import LARGEST, Array

RELATIVE = 1e-6
SMALLEST = 1e-9


def power(waves: Array) -> Array:
    """Return the squared length of each row."""
    return np.asarray(np.sum(waves**2, axis=-1))


def differs(left: Array, right: Array) -> float | None:
    """Return the largest difference where it is more than rounding can explain, else None."""
    if not left.size:
        return None
    gap = float(np.abs(left - right).max())
    size = float(max(np.abs(left).max(), np.abs(right).max()))
    return gap if gap > SMALLEST + RELATIVE * size else None


def off(text: str, unit: str, left: Array, right: Array, rows: Any = ...) -> Iterator[str]:
    """Yield in words by how much two sides of an invariant are off in some rows, if they are."""
    if (gap := differs(left[rows], right[rows])) is not None:
        yield f"{text}, {gap:.3g} {unit} off"


def missing(text: str, values: Array, known: Array) -> Iterator[str]:
    """Yield in words how far an energy [J] is from all ``known`` ones, beyond rounding."""
    if not values.size or not known.size:
        return
    known = np.sort(known)
    index = np.searchsorted(known, values)
    below = np.abs(values - known[np.maximum(index - 1, 0)])
    above = np.abs(values - known[np.minimum(index, len(known) - 1)])
    gap = np.minimum(below, above)
    worst = int(np.argmax(gap - RELATIVE * np.abs(values)))
    if gap[worst] > 1e-12 + RELATIVE * abs(values[worst]):
        yield f"{text}, {gap[worst]:.3g} J off"


def no_numbers(owner: str, signals: Mapping[str, Array]) -> Iterator[str]:
    """Yield in words which signals have values that are not finite, or that nothing real has."""
    for name, values in signals.items():
        finite = np.isfinite(values)
        if count := (~finite).sum():
            yield f"{owner}: {name} has {count} values that are not finite"
        if count := (finite & (np.abs(values) > LARGEST)).sum():
            yield f"{owner}: {name} has {count} values beyond {LARGEST:g}"
