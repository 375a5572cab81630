# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The defects that can be put into a source, each of them a change of one node of its tree."""

import ast
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

SWAPPED = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
OTHER: dict[type, type] = {
    **{ast.Add: ast.Sub, ast.Sub: ast.Add, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd},
    **{ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE},
    **{ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And},
    **{ast.USub: ast.UAdd},
}
WORDS = (ast.JoinedStr, ast.Raise, ast.Assert, ast.AnnAssign, ast.arg)  # texts, errors, types


class Defect(NamedTuple):
    """A change of the node with a number in the walk through a tree."""

    line: int
    kind: str
    node: int

    def put_into(self, source: str) -> str:
        """Return the source with the defect, as a tree is written."""
        tree = ast.parse(source)
        nodes = list(_walk(tree, building=False))
        KINDS[self.kind][1](nodes[self.node][0])
        return ast.unparse(tree)


def defects(source: str) -> Iterator[Defect]:
    """Give every defect that a source can have."""
    for number, (node, building) in enumerate(_walk(ast.parse(source), building=False)):
        for kind, (can, _) in KINDS.items():
            if can(node) and not (building and kind == "statement"):
                yield Defect(node.lineno, kind, number)


def _walk(node: ast.AST, *, building: bool) -> Iterator[tuple[Any, bool]]:
    """Give all nodes that act, and whether they are part of an ``__init__``."""
    if isinstance(node, ast.FunctionDef):
        building, children = node.name == "__init__", list[ast.AST](node.body)
    else:
        yield node, building
        children = list(ast.iter_child_nodes(node))
    for child in children:
        strict = isinstance(child, ast.keyword) and child.arg == "strict"  # of zip
        if not isinstance(child, WORDS) and not strict:
            yield from _walk(child, building=building)


def _is_text(node: ast.BinOp) -> bool:
    sides = [side for side in (node.left, node.right) if isinstance(side, ast.Constant)]
    joined = isinstance(node.left, ast.JoinedStr) or isinstance(node.right, ast.JoinedStr)
    return joined or any(isinstance(side.value, str | None) for side in sides)


def _other(node: Any) -> None:
    if isinstance(node, ast.Compare):
        node.ops[0] = OTHER[type(node.ops[0])]()
    else:
        node.op = OTHER[type(node.op)]()


def _constant(node: Any) -> None:
    number = 2 * node.value if node.value else 1
    node.value = not node.value if isinstance(node.value, bool) else number


def _arguments(node: Any) -> None:
    node.args[:2] = reversed(node.args[:2])


def _swap(node: Any) -> None:
    node.id = SWAPPED[node.id]


def _negate(node: Any) -> None:
    node.test = ast.UnaryOp(ast.Not(), node.test)


def _leave_out(node: Any) -> None:
    node.__class__ = ast.Pass


def _orders_arguments(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call) or len(node.args) < 2:
        return False
    commutes = isinstance(node.func, ast.Name) and node.func.id in (*SWAPPED, "dot", "isinstance")
    return not commutes and ast.unparse(node.args[0]) != ast.unparse(node.args[1])


def _can_be_left_out(node: ast.AST) -> bool:
    """Tell whether what follows a statement would still find every name."""
    if isinstance(node, ast.Assign):
        kept, value = node.targets[0], ast.walk(node.value)
        names = {each.id for each in value if isinstance(each, ast.Name)}
        return isinstance(kept, ast.Attribute) or getattr(kept, "id", "") in names
    calls = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    return calls or isinstance(node, ast.AugAssign)


KINDS: dict[str, tuple[Callable[[Any], bool], Callable[[Any], None]]] = {
    "sign, and, or": (
        lambda node: (
            isinstance(node, ast.UnaryOp | ast.BinOp | ast.BoolOp)
            and type(node.op) in OTHER
            and not (isinstance(node, ast.BinOp) and _is_text(node))
        ),
        _other,
    ),
    "comparison": (
        lambda node: isinstance(node, ast.Compare) and type(node.ops[0]) in OTHER,
        _other,
    ),
    "constant": (
        lambda node: isinstance(node, ast.Constant) and isinstance(node.value, int | float),
        _constant,
    ),
    "arguments": (_orders_arguments, _arguments),
    "min, max": (lambda node: isinstance(node, ast.Name) and node.id in SWAPPED, _swap),
    "condition": (lambda node: isinstance(node, ast.If | ast.IfExp | ast.While), _negate),
    "statement": (_can_be_left_out, _leave_out),
}
