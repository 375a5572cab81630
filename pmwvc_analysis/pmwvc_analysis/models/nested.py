# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The numbers in the nested tuples that are the state of an end: where they are, and others in
their places.
"""

from collections.abc import Iterable, Iterator, Sequence
from functools import reduce
from typing import Any, TypeAlias

Path: TypeAlias = tuple[int, ...]  # of a number, by positions
Forest: TypeAlias = dict[int, Any]  # of several: by position its number, or those within


def leaves(
    value: Any, path: Path = (), names: tuple[str | int, ...] = ()
) -> Iterator[tuple[Path, tuple[str | int, ...], float]]:
    """Yield the numbers in nested tuples: where, by which names; whole numbers are none."""
    if isinstance(value, float):
        yield path, names, value
    elif isinstance(value, tuple | list):
        for at, name in enumerate(getattr(value, "_fields", range(len(value)))):
            yield from leaves(value[at], (*path, at), (*names, name))


def lists(value: Any, path: Path = ()) -> Iterator[Path]:
    """Yield where in nested tuples there are lists."""
    if isinstance(value, tuple | list):
        yield from [path] * isinstance(value, list)
        for at, part in enumerate(value):
            yield from lists(part, (*path, at))


def forest(paths: Iterable[Path], copied: Iterable[Path]) -> Forest:
    """Return which parts of nested tuples have the numbers at these paths, one after the other,
    and which are lists, which laws may write to.
    """
    found: Forest = {}

    def part(path: Iterable[int]) -> Forest:
        return reduce(lambda part, at: part.setdefault(at, {}), path, found)

    for path in copied:
        part(path)
    for number, (*above, last) in enumerate(paths):
        part(above)[last] = number
    return found


def planted(value: Any, places: Forest, numbers: Sequence[float]) -> Any:
    """Return nested tuples with other numbers at these places."""
    parts = list(value)
    for at, of in places.items():
        parts[at] = numbers[of] if isinstance(of, int) else planted(parts[at], of, numbers)
    if isinstance(value, list):
        return parts
    return value._make(parts) if hasattr(value, "_make") else tuple(parts)
