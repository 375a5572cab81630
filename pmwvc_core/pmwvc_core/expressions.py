# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The expressions that stand for calls in unrolled laws (:mod:`.unrolled`): one per axis, the
larger of two, a NamedTuple. What is used more than once gets a name where it is first evaluated.
"""

import ast
from collections.abc import Callable, Iterator
from itertools import count
from typing import Any

from pmwvc_core.law import vectors
from pmwvc_core.pieces import expression_of, names_values

# Per axis, and how the axes are joined: where empty, they make a vector.
BY_AXIS: dict[Callable[..., Any], tuple[str, str]] = {
    vectors.plus: ("{a}[{i}] + {b}[{i}]", ""),
    vectors.minus: ("{a}[{i}] - {b}[{i}]", ""),
    vectors.times: ("{a}[{i}] * {b}[{i}]", ""),
    vectors.scaled: ("{a}[{i}] * {b}", ""),
    vectors.zero: ("0.0", ""),
    vectors.dot: ("{a}[{i}] * {b}[{i}]", " + "),
    vectors.squared: ("{a}[{i}] * {a}[{i}]", " + "),
    vectors.within: ("-{b} < {a}[{i}] < {b}", " and "),
    vectors.is_zero: ("{a}[{i}] == 0.0", " and "),
}


class Expressions:
    """Expressions for a number of axes, and the globals that they need."""

    def __init__(self, axes: int) -> None:
        """Begin without names."""
        self.axes = axes
        self.globals: dict[str, Any] = {"new_": tuple.__new__, "len": len}
        self._temporary: Iterator[int] = count()

    def alias(self, value: Any, name: str) -> ast.Name:
        """Return a name of the unrolled law for a value."""
        alias = f"{name}_{id(value)}"
        self.globals[alias] = value
        return ast.Name(alias, ast.Load())

    def built(self, kind: type, fields: list[ast.expr]) -> ast.expr:
        """Return a NamedTuple, built without a call of its type."""
        named = self.alias(kind, kind.__name__)
        return ast.Call(ast.Name("new_", ast.Load()), [named, ast.Tuple(fields, ast.Load())], [])

    def new(self) -> str:
        """Return a name that no other value has."""
        return f"t{next(self._temporary)}_"

    def if_long(self, t: str, value: ast.expr, then: ast.expr, other: ast.expr) -> ast.expr:
        """Return ``then`` where a value, from here on ``t``, has one element per axis."""
        named = ast.NamedExpr(ast.Name(t, ast.Store()), value)
        size = ast.Call(ast.Name("len", ast.Load()), [named], [])
        test = ast.Compare(size, [ast.Eq()], [ast.Constant(self.axes)])
        return ast.IfExp(test, then, other)

    def by_type(self, laws: dict[type, Any], name: str, given: list[ast.expr]) -> ast.expr:
        """Return the call of what a table has for the type of the first argument."""
        t = self.new()
        first = ast.NamedExpr(ast.Name(t, ast.Store()), given[0])
        kind = ast.Call(ast.Name("type", ast.Load()), [first], [])
        law = ast.Subscript(self.alias(laws, name), kind, ast.Load())
        return ast.Call(law, [ast.Name(t, ast.Load()), *given[1:]], [])

    def called(self, function: Any, given: list[ast.expr]) -> ast.expr:
        """Return the call of a function as it is."""
        return ast.Call(self.alias(function, function.__name__), given, [])

    def held(self, value: ast.expr) -> tuple[str, str]:
        """Return what stands for a value where it is first used, and after that."""
        if isinstance(value, ast.Name | ast.Constant):
            return ast.unparse(value), ast.unparse(value)
        t = self.new()
        return f"({t} := {ast.unparse(value)})", t

    def by_axis(
        self, function: Any, given: list[ast.expr], how: tuple[str, str] | None = None
    ) -> ast.expr:
        """Return the expression of a function of vectors."""
        form, joined = how or BY_AXIS[function]
        (first, then), *others = map(self.held, given)
        second, again = others[0] if others else ("", "")
        cells = []
        for i in range(self.axes):
            text = form.replace("{a}", first, 1).replace("{b}", second, 1) if i == 0 else form
            cells.append(text.format(a=then, b=again, i=i))
        whole = joined.join(cells) if joined else f"({', '.join(cells)},)"
        if "{a}" not in form and names_values(expression_of(first)):
            whole = f"({first}, {whole})[-1]"  # what it names is needed later
        return expression_of(whole)

    def extreme(self, sign: str, given: list[ast.expr]) -> ast.expr:
        """Return the larger (<) or smaller (>) of two, the first where none is."""
        (first, a), (second, b) = map(self.held, given)
        return expression_of(f"{b} if {first} {sign} {second} else {a}")
