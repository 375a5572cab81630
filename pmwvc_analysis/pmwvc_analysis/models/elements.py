# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws on many elements at a time: each number may be an array with one entry per element.

The source of the law is that of :mod:`pmwvc_core.law`. Where a decision is not the same for all
elements, the law in which it is made is called once for those that decide alike, and what it
returns is put together: it is a pure function, so that is what each element by itself would give.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import cache, reduce
from operator import itemgetter
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from pmwvc_core.errors import PmwvcError
from pmwvc_core.law.family import Family
from pmwvc_core.law.server.coupled_axes import loop_inverse
from pmwvc_core.numeric import Array, Flags

LAWS = ("pmwvc_core.law", "pmwvc_core.plant")
BY_ELEMENT = ("exp", "expm1", "floor", "isfinite", "log1p", "sin", "sqrt")
Path = tuple[str | int, ...]


class DividedError(Exception):
    """Elements decide differently: ``which`` of them one way."""

    def __init__(self, which: Flags) -> None:
        super().__init__("elements decide differently")
        self.which = which


class UnlikeError(PmwvcError, ValueError):
    """Elements that decide differently return what has no common form."""


class Elements(np.ndarray[Any, Any]):
    """A number of a law, ``(elements,)``."""

    def __bool__(self) -> bool:
        """Return the decision of all elements; DividedError where they differ."""
        which = self.view(np.ndarray) != 0
        those = np.count_nonzero(which)
        if 0 < those < which.size:
            raise DividedError(which)
        return bool(those)

    # Not in place: another name may stand for the same number.
    __iadd__, __isub__ = np.ndarray.__add__, np.ndarray.__sub__  # type: ignore[assignment]
    __imul__, __itruediv__ = np.ndarray.__mul__, np.ndarray.__truediv__  # type: ignore[assignment]


def elements(values: Any) -> Any:
    """Return an array as the number of a law."""
    return np.asarray(values).view(Elements)


@cache
def lifted(law: Any) -> Callable[..., Any]:
    """Return a law for elements: takes and returns the same, with arrays where elements differ."""
    inner: list[Callable[..., Any]] = []

    def call(*given: Any) -> Any:
        if not inner:
            more = law.__defaults__, law.__closure__
            inner.append(FunctionType(law.__code__, _module(law), law.__name__, *more))
        try:
            return inner[0](*given)
        except DividedError as divided:
            which = divided.which
        one, other = (call(*_each(itemgetter(part), given)) for part in (which, ~which))
        try:
            return _mapped(lambda x, y: _joined(x, y, which), one, other)
        except UnlikeError as error:
            raise UnlikeError(
                f"{law.__module__}.{law.__name__} decides by its signals between what has no "
                "common form; there is no linear model; use 'pmwvc simulate'"
            ) from error

    return call


def _module(law: Any) -> dict[str, Any]:
    """Return the names of a law's module, with lifted laws, also those of modules of laws."""
    found: dict[str, Any] = {"min": _extreme(min, np.minimum), "max": _extreme(max, np.maximum)}
    own = (*LAWS, law.__module__)
    return found | {name: _of_elements(value, own) for name, value in law.__globals__.items()}


def _of_elements(value: Any, own: tuple[str, ...]) -> Any:
    """Return what a name means in a law for elements."""
    if value is math or value is loop_inverse:
        return MATH if value is math else _inverses
    if isinstance(value, FunctionType) and value.__module__.startswith(own):
        return lifted(value)
    if isinstance(value, Family):
        return lambda first, *others: lifted(value.members[type(first)])(first, *others)
    if isinstance(value, ModuleType) and value.__name__.startswith(LAWS):
        return _Module(value)
    return value


class _Module:
    """A module of laws as another one names it, with lifted laws."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:
        return _of_elements(getattr(self._module, name), LAWS)


def _inverses(loop: Any, numbers: tuple[int, ...]) -> Any:
    """Return (1 + loop)^-1 of every element."""
    n = len(numbers)
    entries = np.broadcast_arrays(*[entry for row in loop for entry in row])
    found = np.linalg.inv(np.eye(n) + np.stack(entries, axis=-1).reshape(-1, n, n))
    return tuple(tuple(elements(found[:, i, j]) for j in numbers) for i in numbers)


def _extreme(of_numbers: Any, of_arrays: Any) -> Callable[..., Any]:
    def extreme(*given: Any) -> Any:
        values: Sequence[Any] = given if len(given) > 1 else given[0]
        several = any(isinstance(value, Elements) for value in values)
        return reduce(of_arrays, values) if several else of_numbers(values)

    return extreme


def _function(name: str) -> Callable[[Any], Any]:
    of_numbers, of_arrays = getattr(math, name), getattr(np, name)
    return lambda value: (of_arrays if isinstance(value, Elements) else of_numbers)(value)


MATH = SimpleNamespace(**vars(math) | {name: _function(name) for name in BY_ELEMENT})


def _mapped(change: Callable[..., Any], *values: Any) -> Any:
    """Return what is made of the numbers of nested tuples; UnlikeError if their forms differ."""
    first = values[0]
    if not isinstance(first, tuple | list):
        return change(*values)
    if len(values) > 1:
        if all(each is first for each in values):
            return first
        if any(type(each) is not type(first) or len(each) != len(first) for each in values):
            raise UnlikeError
    return _like(first, [_mapped(change, *of_all) for of_all in zip(*values, strict=True)])


def _like(value: Any, parts: list[Any]) -> Any:
    """Return parts in the form of a value."""
    if isinstance(value, list):
        return parts
    return value._make(parts) if hasattr(value, "_make") else tuple(parts)


def _each(change: Callable[[Any], Any], value: Any) -> Any:
    """Return nested tuples with other arrays of elements."""
    return _mapped(lambda x: change(x) if isinstance(x, Elements) else x, value)


def _joined(one: Any, other: Any, which: Flags) -> Any:
    """Return the number of all elements."""
    if one is other:
        return one
    numbers = bool, int, float, np.generic, Elements
    if not (isinstance(one, numbers) and isinstance(other, numbers)):
        raise UnlikeError
    if not isinstance(one, Elements) and not isinstance(other, Elements) and one == other:
        return one
    found = np.empty(len(which), np.result_type(one, other))
    found[which], found[~which] = one, other
    return elements(found)


def stacked(values: Sequence[Any]) -> Any:
    """Return several runs as one, with arrays ``(runs,)``; UnlikeError where the forms differ."""

    def whole(*of_runs: Any) -> Any:
        first = of_runs[0]
        same = all(each is first or each == first for each in of_runs)
        return first if same else elements(np.array(of_runs))

    return _mapped(whole, *values)


def repeated(value: Any, columns: int) -> Any:
    """Return nested tuples for so many columns of all runs, column by column."""
    return _each(lambda numbers: elements(np.tile(numbers, columns)), value)


def leaves(value: Any, path: Path = ()) -> dict[Path, Any]:
    """Return the numbers in nested tuples by their paths; whole numbers and flags are none."""
    if isinstance(value, tuple | list):
        parts = (leaves(each, (*path, name)) for name, each in _named(value))
        return {place: number for part in parts for place, number in part.items()}
    real = isinstance(value, float) or (isinstance(value, Elements) and value.dtype == np.float64)
    return {path: value} if real else {}


def planted(value: Any, numbers: dict[Path, Any], path: Path = ()) -> Any:
    """Return nested tuples with other numbers at some paths."""
    if not isinstance(value, tuple | list):
        return numbers.get(path, value)
    return _like(value, [planted(each, numbers, (*path, name)) for name, each in _named(value)])


def _named(value: Sequence[Any]) -> Iterable[tuple[str | int, Any]]:
    """Return the parts of a tuple or list with their names, or their numbers."""
    return zip(getattr(value, "_fields", range(len(value))), value, strict=True)


def text_of(path: Path) -> tuple[str, int]:
    """Return the name of a number, and its axis: the last index of its path."""
    last = max((at for at, each in enumerate(path) if isinstance(each, int)), default=None)
    axis = path[last] if last is not None else 0
    return ".".join(str(each) for at, each in enumerate(path) if at != last), int(axis)


def as_columns(value: Any, columns: int, runs: int) -> Array:
    """Return a number as ``(columns, runs)``."""
    if isinstance(value, Elements):
        return value.view(np.ndarray).reshape(columns, runs)
    return np.full((columns, runs), float(value))
