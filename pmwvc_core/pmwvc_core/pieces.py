# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What unrolled laws (:mod:`.unrolled`) are put together from: the source of a law, the expression
of a short one, and values in the place of its arguments.
"""

import ast
import inspect
import textwrap
from copy import deepcopy
from functools import cache
from types import FunctionType


def expression_of(text: str) -> ast.expr:
    """Return the expression of a text."""
    return ast.parse(text, mode="eval").body


@cache
def definition(law: FunctionType) -> ast.FunctionDef:
    """Return the source of a law."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(law))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    return tree


class Places(ast.NodeTransformer):
    """Puts other names in the place of arguments; the first use of some sets them."""

    def __init__(self, names: dict[str, str], first: dict[str, str]) -> None:
        self.names, self.first = names, first
        self.values: dict[str, ast.expr] = {}

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Give a name another one."""
        if node.id not in self.names:
            return node
        name, inside = self.names[node.id], self.first.pop(node.id, None)
        if inside is None:
            return ast.Name(name, ast.Load())
        return ast.NamedExpr(ast.Name(name, ast.Store()), ast.Name(inside, ast.Load()))


class Values(ast.NodeTransformer):
    """Puts values in the place of names."""

    def __init__(self, values: dict[str, ast.expr]) -> None:
        self._values = values

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Put a value in the place of a name."""
        return deepcopy(self._values[node.id]) if node.id in self._values else node


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


def uses(expression: ast.expr, name: str) -> int:
    """Return how often a name stands in an expression."""
    return sum(isinstance(node, ast.Name) and node.id == name for node in ast.walk(expression))


def returned(law: FunctionType) -> ast.expr | None:
    """Return the expression of a law that is nothing else."""
    body = [each for each in definition(law).body if not is_text(each)]
    if len(body) == 1 and isinstance(body[0], ast.Return):
        return body[0].value
    return None


def is_text(node: ast.stmt) -> bool:
    """Tell whether a statement is a docstring."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
