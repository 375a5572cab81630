# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers and lists of things as people write them: in sentences, tables and pages."""

import math
from collections.abc import Sequence
from typing import Any

_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
NOTHING = "–"
NEGLIGIBLE = 1e-9  # of a unit: what rounding leaves


def quantity(value: float | None, unit: str) -> str:
    """Return a number with an SI prefix that leaves 1..999 in front of the unit."""
    if value is None or not math.isfinite(value):
        return NOTHING
    size = abs(value)
    if size < NEGLIGIBLE:
        return f"0 {unit}"
    factor, prefix = next((p for p in _PREFIXES if size >= p[0]), _PREFIXES[-1])
    return f"{value / factor:.3g} {prefix}{unit}"


def share(ratio: float) -> str:
    """Return a ratio before the whole that it is of: ``12 % of``, ``1.5 times``."""
    if 0.0 < ratio < 1e-4:
        return "less than 0.01 % of"
    return f"{ratio:.3g} times" if ratio > 1.0 else f"{100.0 * ratio:.2f} % of"


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
        if abs(number) < NEGLIGIBLE:
            return "0"
        return f"{number:.0f}" if abs(number) >= 10**digits else f"{number:.{digits}g}"
    return str(value)


def count(number: int, thing: str) -> str:
    """Return a number of things: ``1 user``, ``2 users``."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def listed(texts: Sequence[str], last: str = "and") -> str:
    """Return texts as a list in a sentence: ``a``, ``a and b``, ``a, b and c``."""
    if len(texts) < 2:
        return "".join(texts)
    return f"{', '.join(texts[:-1])} {last} {texts[-1]}"
