# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws as Python runs them fastest, for one number of axes, made from their own source.

A loop over axes becomes one expression per axis, a family is looked up where it is called, and a
NamedTuple is built without the functions that ``typing`` makes for it. Values and the order of
additions stay the same, so results have the same bits. Only rows, such as those of users, may have
another number of elements than axes.
"""

import __future__

import ast
import inspect
import re
import textwrap
from collections.abc import Callable
from functools import cache
from itertools import count, zip_longest
from types import FunctionType
from typing import Any, get_args

from pmwvc_core.law import vectors
from pmwvc_core.law.family import Family

LAWS = ("pmwvc_core.law", "pmwvc_core.plant", "pmwvc_core.simulation")
_LOOPS: tuple[Any, ...] = (vectors.each, vectors.chain, vectors.columns, *vectors.BY_AXIS)
_IS_NAME = re.compile(r"[A-Za-z_]\w*|[\d.]+(e-?\d+)?").fullmatch  # or a number
_IS_READ = re.compile(r"-?[\w.]+(\[\w+\])*").fullmatch  # nothing is worked out in it


@cache
def unrolled(law: Callable[..., Any], axes: int) -> Any:
    """Return a law for so many axes: takes and returns the same."""
    return _Unrolling(law, axes).law()


class ByType(dict[type, Any]):
    """The unrolled laws of a family by the type of the first argument, made when asked for."""

    def __init__(self, family: Family, axes: int) -> None:
        super().__init__()
        self._family, self._axes = family, axes

    def __missing__(self, kind: type) -> Any:
        law = self._family.members[kind]
        self[kind] = unrolled(law, self._axes) if law.__module__.startswith(LAWS) else law
        return self[kind]


members = cache(ByType)


class _Unrolling(ast.NodeTransformer):
    """One law under way."""

    def __init__(self, law: Any, axes: int) -> None:
        self._law, self._axes, self._numbers = law, axes, count()
        self._local, self._types = {*law.__code__.co_varnames}, {**law.__annotations__}
        self._globals: dict[str, Any] = {**law.__globals__, "new_": tuple.__new__}
        self._globals["each_"] = vectors.each

    def law(self) -> Any:
        """Return the law."""
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(self._law))).body
        assert isinstance(tree, ast.FunctionDef)
        tree.decorator_list, tree.args.defaults = [], []
        tree.body = [self.visit(each) for each in tree.body]
        module = ast.fix_missing_locations(ast.Module([tree], []))
        file, as_texts = f"<unrolled {self._law.__module__}>", __future__.annotations.compiler_flag
        exec(compile(module, file, "exec", as_texts), self._globals)
        return self._globals[tree.name]

    def _value(self, node: ast.expr) -> Any:
        """Return the object that a name of the law's module or of Python stands for, else None."""
        if not isinstance(node, ast.Name) or node.id in self._local:
            return None
        of_python = __builtins__ if isinstance(__builtins__, dict) else vars(__builtins__)
        return self._law.__globals__.get(node.id, of_python.get(node.id))

    def _type(self, node: ast.expr) -> Any:
        """Return the type of what an expression gives, as far as annotations tell, else None."""
        if isinstance(node, ast.Name):
            return self._types.get(node.id)
        if isinstance(node, ast.Attribute):
            return getattr(self._type(node.value), "__annotations__", {}).get(node.attr)
        if isinstance(node, ast.Tuple):
            return tuple[*map(self._type, node.elts)]  # type: ignore[misc]
        if not isinstance(node, ast.Call):
            return None
        function = self._value(node.func)
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self._type(node.func.value)
        return getattr(function, "__annotations__", {}).get("return", function)

    def _text(self, node: ast.expr) -> str:
        """Return the text of an expression, unrolled."""
        return ast.unparse(self.visit(node))

    def _alias(self, value: Any) -> str:
        """Return a name of the unrolled law for a value."""
        alias = f"{getattr(value, '__name__', 'v')}_{id(value)}".strip("<>")
        self._globals[alias] = value
        return alias

    def _named(self, text: str, uses: int = 2) -> tuple[str, str]:
        """Return what stands for a value where it is first used, and after that."""
        if uses < 2 or _IS_NAME(text):
            text = text if _IS_READ(text) else f"({text})"
            return text, text
        name = f"t{next(self._numbers)}_"
        return f"({name} := {text})", name

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Have laws of the module unrolled."""
        found = self._value(node)
        if isinstance(found, FunctionType) and found.__module__.startswith(LAWS):
            if found not in _LOOPS:
                self._globals[node.id] = unrolled(found, self._axes)
        return node

    def visit_Assign(self, node: ast.Assign) -> ast.stmt:
        """Note the types of names."""
        target, kind = node.targets[0], self._type(node.value)
        node.value = self.visit(node.value)
        names, kinds = [target], [kind]
        if isinstance(target, ast.Tuple):
            names, kinds = target.elts, [*get_args(kind)]
        for name, kind in zip_longest(names, kinds):
            if isinstance(name, ast.Name):
                self._types[name.id] = kind
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Put in the place of a call what is quicker."""
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return _expression(self._replaced(node.func.value, node.keywords))
        function, given = self._value(node.func), node.args
        if node.keywords or function is None or any(isinstance(a, ast.Starred) for a in given):
            self.generic_visit(node)
            return node
        if function is vectors.each and isinstance(given[1], ast.Tuple):
            return _expression(self._each(given[0], given[1].elts, given[2:]))
        return _expression(self._applied(function, node.func, [*map(self._text, given)]))

    def _applied(self, function: Any, named: ast.expr, given: list[str]) -> str:
        """Return the call of a function; where there is something quicker, that in its place."""
        if function in vectors.BY_AXIS:
            return self._by_axis(*vectors.BY_AXIS[function], *given)
        if function in (min, max) and len(given) == 2:
            (first, a), (second, b) = map(self._named, given)
            return f"{b} if {first} {'<' if function is max else '>'} {second} else {a}"
        if isinstance(function, Family):
            first, s = self._named(given[0])
            laws = self._alias(members(function, self._axes))
            return f"{laws}[type({first})]({', '.join([s, *given[1:]])})"
        if isinstance(function, type) and len(getattr(function, "_fields", ())) == len(given):
            return f"new_({self._alias(function)}, {_tuple(given)})"
        return f"{self._text(named)}({', '.join(given)})"

    def _by_axis(self, form: str, joined: str, *given: str) -> str:
        """Return the expression of a function of vectors."""
        uses = [form.count(name) * self._axes for name in ("{a}", "{b}")]
        (first, then), *others = map(self._named, given, uses)
        second, again = others[0] if others else ("", "")
        cells = []
        for i in range(self._axes):
            text = form.replace("{a}", first, 1).replace("{b}", second, 1) if i == 0 else form
            cells.append(text.format(a=then, b=again, i=i))
        return f"({joined.join(cells)})" if joined else _tuple(cells)

    def _replaced(self, of: ast.expr, keywords: list[ast.keyword]) -> str:
        """Return a NamedTuple with other fields: built here where its type is known."""
        kind, s = self._type(of), self._text(of)
        given = {str(each.arg): self._text(each.value) for each in keywords}
        if not hasattr(kind, "_fields"):
            return f"{s}._replace({', '.join(map('='.join, given.items()))})"
        first, s = self._named(s)
        kept = {name: f"{s}[{i}]" for i, name in enumerate(kind._fields)}
        built = f"new_({self._alias(kind)}, {_tuple([*(kept | given).values()])})"
        return built if first == s else f"({first}, {built})[1]"

    def _each(self, law: ast.expr, rows: list[ast.expr], shared: list[ast.expr]) -> str:
        """Return the calls of a law for every axis, where rows have as many elements."""
        pairs, n = [self._named(self._text(node)) for node in (*rows, *shared)], len(rows)
        heads, given = [first for first, text in pairs if first != text], [t for _, t in pairs]
        cells = [
            self._applied(self._value(law), law, [f"{row}[{i}]" for row in given[:n]] + given[n:])
            for i in range(self._axes)
        ]
        loop = f"each_({', '.join([self._text(law), _tuple(given[:n]), *given[n:]])})"
        found = f"{_tuple(cells)} if len({given[0]}) == {self._axes} else {loop}"
        return f"({', '.join([*heads, found])})[-1]" if heads else f"({found})"


def _expression(text: str) -> ast.expr:
    return ast.parse(text, mode="eval").body


def _tuple(elements: list[str]) -> str:
    return f"({', '.join(elements)},)" if elements else "()"
