# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws as Python runs them fastest, for one number of axes, made from the source of the law itself
as compiled ones are (:mod:`.compiled`).

A loop over axes becomes one expression per axis, a family is looked up where it is called, a
NamedTuple is built without the functions that ``typing`` makes for it, and a law of one expression
stands where it is called. Values and the order of additions stay the same, so results have the
same bits. Only rows, such as those of users, may have another number of elements than axes.
"""

import ast
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from types import FunctionType
from typing import Any, get_args

from pmwvc_core import expressions as texts
from pmwvc_core.expressions import BY_AXIS, ByType, Expressions, expression_of, names_values
from pmwvc_core.law import vectors
from pmwvc_core.law.family import Family

LAWS = ("pmwvc_core.law", "pmwvc_core.plant", "pmwvc_core.simulation")
LONGEST = 40  # nodes of an expression that stands where it is called
_BUILDING: tuple[Any, ...] = (vectors.each, vectors.chain, vectors.columns, *BY_AXIS)


@cache
def unrolled(law: Callable[..., Any], axes: int) -> Any:
    """Return a law for so many axes: takes and returns the same."""
    return _Unrolling(axes).function(law)


@cache
def members(family: Family, axes: int) -> ByType:
    """Return the unrolled laws of a family by the type of the first argument."""

    def made(kind: type) -> Any:
        law = family.members[kind]
        return unrolled(law, axes) if law.__module__.startswith(LAWS) else law

    return ByType(made)


class _Unrolling(Expressions, ast.NodeTransformer):
    """One law under way. Globals get names of their own: other laws come to stand in it."""

    def function(self, law: Any) -> Any:
        """Return the law."""
        tree = deepcopy(texts.definition(law))
        self._enter(law)
        tree.decorator_list, tree.args.defaults, tree.returns = [], [], None
        for each in ast.walk(tree.args):
            if isinstance(each, ast.arg):
                each.annotation = None
        tree.body = [self.visit(each) for each in tree.body]
        module = ast.fix_missing_locations(ast.Module([tree], []))
        exec(compile(module, f"<unrolled {law.__module__}>", "exec"), self.globals)
        return self.globals[tree.name]

    def _enter(self, law: Any) -> None:
        """Begin with a law; names have types as far as annotations tell."""
        self._of, self._local = law, {*law.__code__.co_varnames}
        self._types: dict[str, Any] = {**law.__annotations__}
        # Of arguments of a law that stands where it is called: the name of the value, and where
        # the first use is to name it, the value.
        self._places: dict[str, tuple[str, ast.expr | None]] = {}

    def _value(self, node: ast.expr) -> Any:
        """Return the object that a name of the law's module or of Python stands for, else None."""
        if not isinstance(node, ast.Name) or node.id in self._local:
            return None
        of_python = __builtins__ if isinstance(__builtins__, dict) else vars(__builtins__)
        return self._of.__globals__.get(node.id, of_python.get(node.id))

    def _type(self, node: ast.expr) -> Any:
        """Return the type of what an expression gives, as far as annotations tell, else None."""
        if isinstance(node, ast.Name):
            return self._types.get(node.id)
        if isinstance(node, ast.Attribute):
            return getattr(self._type(node.value), "__annotations__", {}).get(node.attr)
        if not isinstance(node, ast.Call):
            return None
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self._type(node.func.value)
        function = self._value(node.func)
        known = isinstance(function, FunctionType)
        return function.__annotations__.get("return") if known else function

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Put values in the place of arguments; give globals names of their own."""
        if node.id in self._places:
            name, value = self._places[node.id]
            self._places[node.id] = name, None
            if value is None:
                return ast.Name(name, ast.Load())
            return ast.NamedExpr(ast.Name(name, ast.Store()), value)
        found = self._value(node)
        if found is None:
            return node
        if isinstance(found, FunctionType) and found.__module__.startswith(LAWS):
            found = found if found in _BUILDING else unrolled(found, self.axes)
        return self.alias(found, node.id)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.stmt:
        """Leave types out."""
        assert node.value is not None
        return ast.Assign([self.visit(node.target)], self.visit(node.value), lineno=1)

    def visit_Assign(self, node: ast.Assign) -> ast.stmt:
        """Take the columns of what ``each`` returns apart, and note the types of names."""
        target, value = node.targets[0], node.value
        names = target.elts if isinstance(target, ast.Tuple) else [target]
        kinds = [self._type(value)]
        if isinstance(target, ast.Tuple):
            kinds = [*get_args(kinds[0])]
            if isinstance(value, ast.Tuple):
                kinds = [*map(self._type, value.elts)]
        if len(kinds) != len(names):
            kinds = [None] * len(names)
        called = value.func if isinstance(value, ast.Call) else target
        split = isinstance(target, ast.Tuple) and self._value(called) is vectors.columns
        self.generic_visit(node)
        if split and isinstance(node.value, ast.Call):
            (rows,), t = node.value.args, self.new()
            cells = [
                f"({', '.join(f'{t}[{i}][{k}]' for i in range(self.axes))},)"
                for k in range(len(names))
            ]
            other = self.called(vectors.columns, [ast.Name(t, ast.Load())])
            node.value = self.if_long(t, rows, expression_of(f"({', '.join(cells)},)"), other)
        for name, kind in zip(names, kinds, strict=True):
            if isinstance(name, ast.Name):
                self._types[name.id] = kind
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Put in the place of a call what is quicker."""
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self._replaced(node.func.value, node.keywords)
        function = self._value(node.func)
        if node.keywords or function is None:
            self.generic_visit(node)
            return node
        if function is vectors.each and isinstance(node.args[1], ast.Tuple):
            return self._each(node.args[0], node.args[1].elts, node.args[2:])
        given = [self.visit(each) for each in node.args]
        if any(isinstance(each, ast.Starred) for each in given):
            return ast.Call(self.visit(node.func), given, [])
        if function in BY_AXIS:
            return self.by_axis(*BY_AXIS[function], given)
        if function is vectors.length and self.axes == 1:
            return self.by_axis("abs({a}[{i}])", " + ", given)
        if function in (min, max) and len(given) == 2:
            return self.extreme("<" if function is max else ">", given)
        return self._applied(function, node.func, given)

    def _applied(self, function: Any, named: ast.expr, given: list[ast.expr]) -> ast.expr:
        """Return the call of a law; a tuple and a short law in its place, a family by type."""
        if isinstance(function, Family):
            return self.by_type(members(function, self.axes), function.name, given)
        if isinstance(function, type) and hasattr(function, "_fields"):
            return self.built(function, given)
        if isinstance(function, FunctionType) and _is_short(function):
            return self._in_place(function, given)
        return ast.Call(self.visit(deepcopy(named)), given, [])

    def _replaced(self, of: ast.expr, keywords: list[ast.keyword]) -> ast.expr:
        """Return a NamedTuple with other fields: built here where its type is known."""
        kind, s = self._type(of), self.visit(of)
        given = {str(each.arg): self.visit(each.value) for each in keywords}
        fields = getattr(kind, "_fields", ())
        sorted_ = [name for name in fields if name in given] == [*given]
        free = sorted_ or not any(map(names_values, given.values()))
        if not fields or not isinstance(s, ast.Name) or not free:
            return self.by_type(texts.replacing((*given,)), "replacing", [s, *given.values()])
        kept = {name: expression_of(f"{s.id}[{i}]") for i, name in enumerate(fields)}
        return self.built(kind, [*(kept | given).values()])

    def _each(self, law: ast.expr, rows: list[ast.expr], shared: list[ast.expr]) -> ast.expr:
        of_rows, of_all = [*map(self.visit, rows)], [*map(self.visit, shared)]
        t, chosen, cells = self.new(), self._value(law), list[ast.expr]()
        other, for_all = [*map(self.held, of_rows[1:])], [*map(self.held, of_all)]
        for i in range(self.axes):
            of_one = [f"{t}[{i}]", *[f"{pair[i > 0]}[{i}]" for pair in other]]
            known = [expression_of(text) for text in [*of_one, *[pair[i > 0] for pair in for_all]]]
            cells.append(self._applied(chosen, law, known))
        every = [ast.Name(t, ast.Load()), *map(deepcopy, of_rows[1:])]
        rest = [ast.Tuple(every, ast.Load()), *map(deepcopy, of_all)]
        loop = self.called(vectors.each, [self.visit(law), *rest])
        return self.if_long(t, of_rows[0], ast.Tuple(cells, ast.Load()), loop)

    def _in_place(self, law: FunctionType, given: list[ast.expr]) -> ast.expr:
        """Return the expression of a short law with its arguments put in."""
        expression: Any = deepcopy(texts.returned(law))
        used = [node.id for node in ast.walk(expression) if isinstance(node, ast.Name)]
        outer = self._of, self._local, self._types, self._places
        self._enter(law)
        heads, ordered = [], texts.in_order(expression)
        for argument, value in zip(texts.definition(law).args.args, given, strict=True):
            name = argument.arg
            if isinstance(value, ast.Name):
                self._places[name] = value.id, None
                continue
            t = self.new()
            # What names a value on its way must be evaluated, whichever way the law goes.
            if ordered or (used.count(name) == 1 and not names_values(value)):
                self._places[name] = t, value
            else:
                self._places[name] = t, None
                heads.append(f"({t} := {ast.unparse(value)})")
        body = self.visit(expression)
        self._of, self._local, self._types, self._places = outer
        if heads:
            return expression_of(f"({', '.join(heads)}, {ast.unparse(body)})[-1]")
        return body  # type: ignore[no-any-return]


@cache
def _is_short(law: FunctionType) -> bool:
    """Tell whether a law stands where it is called."""
    inside = law.__module__.startswith(LAWS) and law not in _BUILDING
    expression = texts.returned(law) if inside else None
    return expression is not None and sum(1 for _ in ast.walk(expression)) <= LONGEST
