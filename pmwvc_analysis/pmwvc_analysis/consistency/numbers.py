# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Differences of recorded numbers beyond what rounding explains."""

import numpy as np

from pmwvc_core.numeric import LARGEST, Array

RELATIVE = 1e-6
SMALLEST = 1e-9


def differs(left: Array, right: Array) -> float | None:
    """Return the largest difference where it is more than rounding can explain, else None."""
    if not left.size:
        return None
    gap = float(np.abs(left - right).max())
    size = float(max(np.abs(left).max(), np.abs(right).max()))
    return gap if gap > SMALLEST + RELATIVE * size else None


def off(left: Array, right: Array, text: str, unit: str) -> list[str]:
    """Return in words by how much numbers are off; empty where rounding explains it."""
    gap = differs(left, right)
    return [] if gap is None else [f"{text}, {gap:.3g} {unit} off"]


def missing_from(values: Array, known: Array) -> float | None:
    """Return how far a value is from all of the sorted ``known`` beyond rounding, or None."""
    if not values.size or not known.size:
        return None
    index = np.searchsorted(known, values)
    below = np.abs(values - known[np.maximum(index - 1, 0)])
    above = np.abs(values - known[np.minimum(index, len(known) - 1)])
    gap = np.minimum(below, above)
    worst = int(np.argmax(gap - RELATIVE * np.abs(values)))
    return float(gap[worst]) if gap[worst] > 1e-12 + RELATIVE * abs(values[worst]) else None


def no_numbers(owner: str, signals: dict[str, Array]) -> list[str]:
    """Return in words which signals have values that are not finite, or that no device and no
    controller has: sums of their squares would be infinite.
    """
    found = []
    for name, values in signals.items():
        finite = np.isfinite(values)
        for what, count in (
            ("that are not finite", (~finite).sum()),
            (f"beyond {LARGEST:g}", (finite & (np.abs(values) > LARGEST)).sum()),
        ):
            found += [f"{owner}: {name} has {count} values {what}"] if count else []
    return found
