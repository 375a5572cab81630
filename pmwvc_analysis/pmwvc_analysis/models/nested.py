# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The numbers in the nested tuples that are the state of an end, in a row; integers are none."""

from collections.abc import Iterator, Sequence
from typing import Any


def named(value: Any, names: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Yield the names of all numbers in nested tuples."""
    if isinstance(value, float):
        yield names
    elif isinstance(value, tuple | list):
        for part, name in zip(value, getattr(value, "_fields", range(len(value))), strict=True):
            yield from named(part, (*names, name))


def numbers_in(value: Sequence[Any]) -> list[float]:
    """Return all numbers in nested tuples."""
    found: list[float] = []
    for part in value:
        if isinstance(part, float):
            found.append(part)
        elif isinstance(part, tuple | list):
            found += numbers_in(part)
    return found


def planted(value: Any, numbers: Iterator[float]) -> Any:
    """Return nested tuples with other numbers, and lists of their own, which laws may write to."""
    if isinstance(value, float):
        return next(numbers)
    if not isinstance(value, tuple | list):
        return value
    parts = [planted(part, numbers) for part in value]
    return parts if isinstance(value, list) else tuple.__new__(type(value), parts)
