# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers as people write them."""

import math
from typing import Any

from pmwvc_core.plural import count

_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
NOTHING = "–"


def quantity(value: float | None, unit: str) -> str:
    """Return a number with an SI prefix that leaves 1..999 in front of the unit."""
    if value is None or not math.isfinite(value):
        return NOTHING
    size = abs(value)
    if size < 1e-12:
        return f"0 {unit}"
    factor, prefix = next((p for p in _PREFIXES if size >= p[0]), _PREFIXES[-1])
    return f"{value / factor:.3g} {prefix}{unit}"


def users(number: int) -> str:
    """Return how many users there are."""
    return count(number, "user")


def cell(value: Any, scale: float = 1.0, digits: int = 3) -> str:
    """Return what stands in a table cell: numbers scaled and rounded, flags as words."""
    if value is None:
        return NOTHING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(cell(entry, scale, digits) for entry in value)
    if isinstance(value, float):
        number = value * scale
        return f"{number:.0f}" if abs(number) >= 10**digits else f"{number:.{digits}g}"
    return str(value)
