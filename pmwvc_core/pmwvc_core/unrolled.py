# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws as Python runs them fastest, for one number of axes, made from their own source.

A loop over axes becomes one expression per axis, a family is looked up where it is called, a
NamedTuple is built without the functions that ``typing`` makes for it, and a law of one expression
stands where it is called. Values and the order of additions stay the same, so results have the
same bits. Only rows, such as those of users, may have another number of elements than axes.
"""

import __future__

import ast
import inspect
import re
import textwrap
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from itertools import count, zip_longest
from types import FunctionType
from typing import Any, get_args

from pmwvc_core.law import vectors
from pmwvc_core.law.family import Family

LAWS = ("pmwvc_core.law", "pmwvc_core.plant", "pmwvc_core.simulation")
LONGEST = 40  # nodes of an expression that stands where it is called
_LOOPS: tuple[Any, ...] = (vectors.each, vectors.chain, vectors.columns, *vectors.BY_AXIS)
_IS_NAME = re.compile(r"[A-Za-z_]\w*|[\d.]+(e-?\d+)?").fullmatch  # or a number
_IS_READ = re.compile(r"-?[\w.]+(\[\w+\])*").fullmatch  # nothing is worked out in it


@cache
def unrolled(law: Callable[..., Any], axes: int) -> Any:
    """Return a law for so many axes: takes and returns the same."""
    return _Unrolling(axes).function(law)


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


@cache
def _definition(law: FunctionType) -> Any:
    """Return the source of a law, without its docstring."""
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(law))).body
    assert isinstance(tree, ast.FunctionDef)
    tree.body = tree.body[ast.get_docstring(tree) is not None :]
    return tree


@cache
def _is_short(law: Any) -> bool:
    """Tell whether a law stands where it is called: one short expression."""
    if not isinstance(law, FunctionType) or not law.__module__.startswith(LAWS) or law in _LOOPS:
        return False
    first, *others = _definition(law).body
    return isinstance(first, ast.Return) and not others and len([*ast.walk(first)]) <= LONGEST


class _Unrolling(ast.NodeTransformer):
    """One law under way. Globals get names of their own: other laws come to stand in it."""

    def __init__(self, axes: int) -> None:
        """Begin without names."""
        self._axes, self._numbers = axes, count()
        self._globals: dict[str, Any] = {"new_": tuple.__new__, "each_": vectors.each}

    def function(self, law: Any) -> Any:
        """Return the law."""
        tree = deepcopy(_definition(law))
        self._enter(law, {})
        tree.decorator_list, tree.args.defaults = [], []
        tree.body = [self.visit(each) for each in tree.body]
        module = ast.fix_missing_locations(ast.Module([tree], []))
        file, as_texts = f"<unrolled {law.__module__}>", __future__.annotations.compiler_flag
        exec(compile(module, file, "exec", as_texts), self._globals)
        return self._globals[tree.name]

    def _enter(self, law: Any, places: dict[str, str]) -> None:
        """Begin with a law; of its arguments, some have other texts in their places."""
        self._of, self._local, self._places = law, {*law.__code__.co_varnames}, places
        self._types: dict[str, Any] = {**law.__annotations__}

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
        """Put other texts in the place of arguments; give globals names of their own."""
        if node.id in self._places:
            return _expression(self._places[node.id])
        found = self._value(node)
        if found is None:
            return node
        if isinstance(found, FunctionType) and found.__module__.startswith(LAWS):
            found = found if found in _LOOPS else unrolled(found, self._axes)
        return _expression(self._alias(found))

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
        if _is_short(function):
            return self._in_place(function, given)
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
        given, n = [*map(self._text, [*rows, *shared])], len(rows)
        first, given[0] = self._named(given[0])
        heads, given = self._read(given)
        cells = [
            self._applied(self._value(law), law, [f"{row}[{i}]" for row in given[:n]] + given[n:])
            for i in range(self._axes)
        ]
        loop = f"each_({', '.join([self._text(law), _tuple(given[:n]), *given[n:]])})"
        return _after(heads, f"{_tuple(cells)} if len({first}) == {self._axes} else {loop}")

    def _read(self, given: list[str], once: tuple[bool, ...] = ()) -> tuple[list[str], list[str]]:
        """Return what names values that are worked out, and what stands for all of them then."""
        rows = zip_longest(given, once)
        pairs = [(a, a) if is_once or _IS_READ(a) else self._named(a) for a, is_once in rows]
        return [first for first, text in pairs if first != text], [text for _, text in pairs]

    def _in_place(self, law: FunctionType, given: list[str]) -> str:
        """Return the expression of a short law with its arguments put in."""
        tree, outer = _definition(law), (self._of, self._local, self._places, self._types)
        body, names = deepcopy(tree.body[0].value), [each.arg for each in tree.args.args]
        used = [each.id for each in ast.walk(body) if isinstance(each, ast.Name)]
        heads, given = self._read(given, tuple(used.count(name) < 2 for name in names))
        self._enter(law, dict(zip(names, given, strict=True)))
        text = self._text(body)
        self._of, self._local, self._places, self._types = outer
        return _after(heads, text)


def _expression(text: str) -> ast.expr:
    return ast.parse(text, mode="eval").body


def _tuple(elements: list[str]) -> str:
    return f"({', '.join(elements)},)" if elements else "()"


def _after(heads: list[str], text: str) -> str:
    return f"({', '.join([*heads, text])})[-1]" if heads else f"({text})"
