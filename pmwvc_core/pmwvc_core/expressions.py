# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sources of laws, and the expressions that stand for calls in unrolled ones
(:mod:`.unrolled`): one per axis, the larger of two, a NamedTuple. What is used more than once gets
a name where it is first evaluated.
"""

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterator
from functools import cache
from itertools import count
from types import FunctionType
from typing import Any

from pmwvc_core.law import vectors

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


def expression_of(text: str) -> ast.expr:
    """Return the expression of a text."""
    return ast.parse(text, mode="eval").body


@cache
def definition(law: FunctionType) -> ast.FunctionDef:
    """Return the source of a law, without its docstring."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(law))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    first = tree.body[0]
    if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
        del tree.body[0]
    return tree


def returned(law: FunctionType) -> ast.expr | None:
    """Return the expression of a law that is nothing else."""
    body = definition(law).body
    return body[0].value if len(body) == 1 and isinstance(body[0], ast.Return) else None


def in_order(expression: ast.expr) -> bool:
    """Tell whether all of an expression is evaluated, from left to right."""
    return not any(
        isinstance(node, ast.IfExp | ast.BoolOp)
        or (isinstance(node, ast.Compare) and len(node.ops) > 1)
        for node in ast.walk(expression)
    )


def names_values(expression: ast.expr) -> bool:
    """Tell whether an expression gives names to values."""
    return any(isinstance(node, ast.NamedExpr) for node in ast.walk(expression))


class ByType(dict[type, Any]):
    """Laws by type, made when first asked for."""

    def __init__(self, make: Callable[[Any], Any]) -> None:
        super().__init__()
        self._make = make

    def __missing__(self, kind: type) -> Any:
        self[kind] = self._make(kind)
        return self[kind]


@cache
def replacing(names: tuple[str, ...]) -> ByType:
    """Return functions (s, values of the named fields) -> s by the type of s."""

    def made(kind: Any) -> Any:
        fields = [name if name in names else f"s_[{i}]" for i, name in enumerate(kind._fields)]
        text = f"lambda s_, {', '.join(names)}: new_(kind_, ({', '.join(fields)},))"
        return eval(text, {"new_": tuple.__new__, "kind_": kind})  # names of fields

    return ByType(made)


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

    def new(self) -> str:
        """Return a name that no other value has."""
        return f"t{next(self._temporary)}_"

    def held(self, value: ast.expr) -> tuple[str, str]:
        """Return what stands for a value where it is first used, and after that."""
        if isinstance(value, ast.Name | ast.Constant):
            return ast.unparse(value), ast.unparse(value)
        t = self.new()
        return f"({t} := {ast.unparse(value)})", t

    def called(self, function: Any, given: list[ast.expr]) -> ast.expr:
        """Return the call of a function as it is."""
        return ast.Call(self.alias(function, function.__name__), given, [])

    def built(self, kind: type, fields: list[ast.expr]) -> ast.expr:
        """Return a NamedTuple, built without a call of its type."""
        named = self.alias(kind, kind.__name__)
        return ast.Call(ast.Name("new_", ast.Load()), [named, ast.Tuple(fields, ast.Load())], [])

    def if_long(self, t: str, value: ast.expr, then: ast.expr, other: ast.expr) -> ast.expr:
        """Return ``then`` where a value, from here on ``t``, has one element per axis."""
        test = expression_of(f"len({t} := {ast.unparse(value)}) == {self.axes}")
        return ast.IfExp(test, then, other)

    def by_type(self, laws: dict[type, Any], name: str, given: list[ast.expr]) -> ast.expr:
        """Return the call of what a table has for the type of the first argument."""
        t = self.new()
        first = ast.NamedExpr(ast.Name(t, ast.Store()), given[0])
        kind = ast.Call(ast.Name("type", ast.Load()), [first], [])
        law = ast.Subscript(self.alias(laws, name), kind, ast.Load())
        return ast.Call(law, [ast.Name(t, ast.Load()), *given[1:]], [])

    def by_axis(self, form: str, joined: str, given: list[ast.expr]) -> ast.expr:
        """Return the expression of a function of vectors."""
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
