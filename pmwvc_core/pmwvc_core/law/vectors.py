# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Vectors as tuples with one float per axis, and laws of one axis applied to each of several.

:mod:`pmwvc_core.compiled` has the compiled form of ``each``, ``chain``, ``columns``, ``plus``,
``minus``, ``times`` and ``scaled``, which build tuples; everything else is made of these.
"""

import math
from collections.abc import Callable
from operator import add, mul, sub, truediv
from typing import Any, TypeAlias

Vector: TypeAlias = tuple[float, ...]
LARGEST = 1e100  # of a measurement or a force [m], [m/s], [N]; what is beyond it, or NaN, is none


def each(law: Callable[..., Any], rows: tuple[tuple[Any, ...], ...], *shared: Any) -> Any:
    """Return ``(law(rows[0][i], rows[1][i], ..., *shared) for every i)`` as a tuple."""
    return tuple([law(*of_one, *shared) for of_one in zip(*rows, strict=True)])


def chain(law: Callable[..., Any], s: tuple[Any, ...], u: float, params: tuple[Any, ...]) -> Any:
    """Return states and output of ``law(state, input, params) -> (state, output)`` in a row."""
    after = []
    for state, p in zip(s, params, strict=True):
        state, u = law(state, u, p)
        after.append(state)
    return tuple(after), u


def columns(rows: tuple[tuple[Any, ...], ...]) -> Any:
    """Return the columns of a table given by its rows: results of ``each`` by kind."""
    return tuple(zip(*rows, strict=True))


def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return tuple(map(add, a, b))


def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return tuple(map(sub, a, b))


def times(a: Vector, b: Vector) -> Vector:
    """Return the products of each axis."""
    return tuple(map(mul, a, b))


def scaled(a: Vector, factor: float) -> Vector:
    """Return a times a number."""
    return tuple([x * factor for x in a])


def inverse(a: Vector) -> Vector:
    """Return 1/a of each axis."""
    return each(truediv, (filled(a, 1.0), a))


def between(a: Vector, b: Vector, ratio: float) -> Vector:
    """Return a + (b - a) ratio: on the way from a to b."""
    return plus(a, scaled(minus(b, a), ratio))


def zero(like: Vector) -> Vector:
    """Return the vector of zeros with as many axes."""
    return filled(like, 0.0)


def filled(like: Vector, value: float) -> Vector:
    """Return the vector with the same number along as many axes."""
    return each(_value, (like,), value)


def _value(x: float, value: float) -> float:
    return value


def dot(a: Vector, b: Vector) -> float:
    """Return the inner product."""
    total = a[0] * b[0]
    for i in range(1, len(a)):
        total += a[i] * b[i]
    return total


def row(number: int, table: Any, axes: tuple[int, ...]) -> Vector:
    """Return a row of an array ``(rows, axes)`` as a vector."""
    found: Vector = each(_element, (axes,), table, number)
    return found


def _element(axis: int, table: Any, number: int) -> float:
    return float(table[number, axis])


def squared(a: Vector) -> float:
    """Return |a|^2."""
    return dot(a, a)


def length(a: Vector) -> float:
    """Return |a|."""
    return abs(a[0]) if len(a) == 1 else math.sqrt(dot(a, a))


def shortened(a: Vector, longest: float) -> Vector:
    """Return a vector of the same direction and at most so long."""
    size = math.sqrt(dot(a, a))
    return scaled(a, longest / size) if size > longest else a


def within(a: Vector, reach: float) -> bool:
    """Tell whether every element is nearer to zero than that; what is no number never is."""
    inside = True
    for i in range(len(a)):
        inside = inside and -reach < a[i] < reach
    return inside


def measured(a: Vector) -> bool:
    """Tell whether a vector may have been measured, or be a force."""
    return within(a, LARGEST)


def total(start: float, values: Vector) -> float:
    """Return the sum of a number and values, in order."""
    for i in range(len(values)):
        start += values[i]
    return start


# By function: its text along an axis, and how the axes are joined (where empty: as a vector).
BY_AXIS: dict[Callable[..., Any], tuple[str, str]] = {
    plus: ("{a}[{i}] + {b}[{i}]", ""),
    minus: ("{a}[{i}] - {b}[{i}]", ""),
    times: ("{a}[{i}] * {b}[{i}]", ""),
    scaled: ("{a}[{i}] * {b}", ""),
    zero: ("0.0", ""),
    dot: ("{a}[{i}] * {b}[{i}]", " + "),
    squared: ("{a}[{i}] * {a}[{i}]", " + "),
    within: ("-{b} < {a}[{i}] < {b}", " and "),
}
