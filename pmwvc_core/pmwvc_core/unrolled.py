# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws as Python runs them fastest, for one number of axes: what is interpreted is made from the
source of the law itself, as what is compiled is (:mod:`.compiled`).

A loop over axes becomes one expression per axis, a family is looked up where it is called, a
NamedTuple is built, or has fields replaced, without the functions that ``typing`` makes for it; a
law of one expression stands where it is called. Values and the order of additions stay the same,
so results have the same bits. What is added or scaled has one element per axis; only rows, such as
those of users, may have another number of elements, and take the way of the source.
"""

import ast
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from types import FunctionType
from typing import Any

from pmwvc_core.expressions import BY_AXIS, Expressions
from pmwvc_core.kinds import Kinds, replacing
from pmwvc_core.law import vectors
from pmwvc_core.law.family import Family
from pmwvc_core.pieces import (
    Places,
    Values,
    definition,
    expression_of,
    in_order,
    is_text,
    names_values,
    returned,
    uses,
)

LAWS = ("pmwvc_core.law", "pmwvc_core.plant", "pmwvc_core.simulation")
LONGEST = 40  # nodes of an expression that stands where it is called


@cache
def unrolled(law: Callable[..., Any], axes: int) -> Any:
    """Return a law for so many axes: takes and returns the same."""
    return _Unrolling(axes).function(law)


class _Members(dict[type, Any]):
    """The unrolled laws of a family by type, made when first called."""

    def __init__(self, family: Family, axes: int) -> None:
        super().__init__()
        self._family, self._axes = family, axes

    def __missing__(self, kind: type) -> Any:
        law = self._family.members[kind]
        inside = law.__module__.startswith(LAWS)
        self[kind] = unrolled(law, self._axes) if inside else law
        return self[kind]


_members = cache(_Members)


class _Unrolling(Expressions, ast.NodeTransformer):
    """One law under way. Globals get names of their own: other laws come to stand in it."""

    def __init__(self, axes: int) -> None:
        super().__init__(axes)
        self._of: FunctionType
        self._local: set[str] = set()
        self._kinds = Kinds(self._value)

    def function(self, law: Any) -> Any:
        """Return the law."""
        tree = deepcopy(definition(law))
        self._enter(law)
        tree.decorator_list, tree.args.defaults, tree.returns = [], [], None
        for each in ast.walk(tree.args):
            if isinstance(each, ast.arg):
                each.annotation = None
        tree.body = [self.visit(each) for each in tree.body if not is_text(each)]
        module = ast.fix_missing_locations(ast.Module([tree], []))
        exec(compile(module, f"<unrolled {law.__module__}>", "exec"), self.globals)
        return self.globals[tree.name]

    def _enter(self, law: Any) -> None:
        self._of, self._local = law, {*law.__code__.co_varnames}
        self._kinds = Kinds(self._value, law)

    def _value(self, node: ast.expr) -> Any:
        """Return the object that a name of the law's module or of Python stands for, else None."""
        if not isinstance(node, ast.Name) or node.id in self._local:
            return None
        of_python = __builtins__ if isinstance(__builtins__, dict) else vars(__builtins__)
        return self._of.__globals__.get(node.id, of_python.get(node.id))

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Give globals the names under which they stand beside each other."""
        value = self._value(node)
        if value is None:
            return node
        if isinstance(value, FunctionType) and value.__module__.startswith(LAWS):
            value = value if value in _BUILDING else unrolled(value, self.axes)
        return self.alias(value, node.id)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.stmt:
        """Leave types out."""
        assert node.value is not None
        return ast.Assign([self.visit(node.target)], self.visit(node.value), lineno=1)

    def visit_Assign(self, node: ast.Assign) -> ast.stmt:
        """Take the columns of what ``each`` returns apart."""
        target, value = node.targets[0], node.value
        known = self._kinds.named(target, value)
        if (
            isinstance(target, ast.Tuple)
            and isinstance(value, ast.Call)
            and self._value(value.func) is vectors.columns
        ):
            rows, t = self.visit(value.args[0]), self.new()
            cells = [
                f"({', '.join(f'{t}[{i}][{k}]' for i in range(self.axes))},)"
                for k in range(len(target.elts))
            ]
            found = expression_of(f"({', '.join(cells)},)")
            other = self.called(vectors.columns, [ast.Name(t, ast.Load())])
            node.value = self.if_long(t, rows, found, other)
            node.targets = [self.visit(target)]
        else:
            self.generic_visit(node)
        self._kinds.update(known)
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Put in the place of a call what is quicker."""
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self._replace(node.func.value, node.keywords)
        function = self._value(node.func)
        if node.keywords or function is None or not isinstance(node.func, ast.Name):
            self.generic_visit(node)
            return node
        if function is vectors.each and isinstance(node.args[1], ast.Tuple):
            return self._each(node.args[0], node.args[1].elts, node.args[2:])
        given = [self.visit(each) for each in node.args]
        if any(isinstance(each, ast.Starred) for each in given):
            return ast.Call(self.visit(node.func), given, [])
        if isinstance(function, Family):
            return self._member(function, given)
        if function in BY_AXIS:
            return self.by_axis(function, given)
        if function is vectors.length and self.axes == 1:
            return self.by_axis(function, given, ("abs({a}[{i}])", " + "))
        if function in (min, max) and len(given) == 2:
            return self.extreme("<" if function is max else ">", given)
        if isinstance(function, type) and hasattr(function, "_fields"):
            return self.built(function, given)
        if isinstance(function, FunctionType) and _is_short(function):
            return self._in_place(function, given)
        return ast.Call(self.visit(node.func), given, [])

    def _replace(self, of: ast.expr, keywords: list[ast.keyword]) -> ast.expr:
        """Return a NamedTuple with other fields: built here where its type is known."""
        kind, s = self._kinds.of(of), self.visit(of)
        given = {str(each.arg): self.visit(each.value) for each in keywords}
        fields = getattr(kind, "_fields", ())
        in_order = [name for name in fields if name in given] == [*given]
        free = in_order or not any(map(names_values, given.values()))
        if kind is None or not isinstance(s, ast.Name) or not free:
            return self.by_type(replacing((*given,)), "replacing", [s, *given.values()])
        kept = (expression_of(f"{s.id}[{i}]") for i in range(len(fields)))
        return self.built(
            kind, [given.get(name, old) for name, old in zip(fields, kept, strict=True)]
        )

    def _member(self, family: Family, given: list[ast.expr]) -> ast.expr:
        """Return the call of the law for the type of the first argument."""
        return self.by_type(_members(family, self.axes), family.name, given)

    def _each(self, law: ast.expr, rows: list[ast.expr], shared: list[ast.expr]) -> ast.expr:
        of_rows = [self.visit(row) for row in rows]
        of_all = [self.visit(one) for one in shared]
        if any(isinstance(one, ast.Starred) for one in of_all):
            every = [ast.Tuple(of_rows, ast.Load()), *of_all]
            return self.called(vectors.each, [self.visit(law), *every])
        t = self.new()
        other = [self.held(row) for row in of_rows[1:]]
        for_all = [self.held(one) for one in of_all]
        chosen, cells = self._value(law), list[ast.expr]()
        for i in range(self.axes):
            of_one = [f"{t}[{i}]", *[f"{pair[i > 0]}[{i}]" for pair in other]]
            texts = [*of_one, *[pair[i > 0] for pair in for_all]]
            known = [expression_of(text) for text in texts]
            if isinstance(chosen, Family):
                cells.append(self._member(chosen, known))
            elif isinstance(chosen, type):
                cells.append(self.built(chosen, known))
            elif isinstance(chosen, FunctionType) and _is_short(chosen):
                cells.append(self._in_place(chosen, known))
            else:
                cells.append(ast.Call(self.visit(deepcopy(law)), known, []))
        every = [ast.Name(t, ast.Load()), *map(deepcopy, of_rows[1:])]
        rest = [ast.Tuple(every, ast.Load()), *map(deepcopy, of_all)]
        loop = self.called(vectors.each, [self.visit(law), *rest])
        return self.if_long(t, of_rows[0], ast.Tuple(cells, ast.Load()), loop)

    def _in_place(self, law: FunctionType, given: list[ast.expr]) -> ast.expr:
        """Return the expression of a short law with its arguments put in."""
        expression: Any = deepcopy(returned(law))
        places = Places({}, {})
        heads = []
        for argument, value in zip(definition(law).args.args, given, strict=True):
            if isinstance(value, ast.Name):
                places.names[argument.arg] = value.id
                continue
            t, inside = self.new(), self.new()
            places.names[argument.arg] = t
            # What names a value on its way must be evaluated, whichever way the law goes.
            once = uses(expression, argument.arg) == 1 and not names_values(value)
            if in_order(expression) or once:
                places.first[argument.arg] = inside
                places.values[inside] = value
            else:
                heads.append(f"({t} := {ast.unparse(value)})")
        outer = self._of, self._local, self._kinds
        self._enter(law)
        self._local |= {*places.names.values()}  # of the caller
        self._kinds.rename(places.names)
        body = self.visit(places.visit(expression))
        self._of, self._local, self._kinds = outer
        body = Values(places.values).visit(body)
        if heads:
            return expression_of(f"({', '.join(heads)}, {ast.unparse(body)})[-1]")
        return body  # type: ignore[no-any-return]


@cache
def _is_short(law: FunctionType) -> bool:
    """Tell whether a law stands where it is called."""
    if not law.__module__.startswith(LAWS) or law in _BUILDING:
        return False
    expression = returned(law)
    return expression is not None and sum(1 for _ in ast.walk(expression)) <= LONGEST


_BUILDING: tuple[Any, ...] = (vectors.each, vectors.chain, vectors.columns, *BY_AXIS)
