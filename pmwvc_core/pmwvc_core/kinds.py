# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Which NamedTuple a name in a law stands for, by the annotations of laws and of fields, so that
unrolled laws (:mod:`.unrolled`) replace fields without a call. What is not known is ``None``.
"""

import ast
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any, get_args


def _tuple_kind(kind: Any) -> Any:
    """Return a type that is a NamedTuple, else None."""
    return kind if isinstance(kind, type) and hasattr(kind, "_fields") else None


class Kinds:
    """The types of the names of a law, as far as they are known; ``value``: of a global."""

    def __init__(self, value: Callable[[ast.expr], Any], law: FunctionType | None = None) -> None:
        self._value = value
        self._of_name = {**law.__annotations__} if law else {}

    def rename(self, names: dict[str, str]) -> None:
        """Let other names stand for those of arguments."""
        self._of_name |= {new: self._of_name.get(old) for old, new in names.items()}

    def of(self, node: ast.expr) -> Any:
        """Return the NamedTuple that an expression gives."""
        return _tuple_kind(self._annotation(node))

    def _annotation(self, node: ast.expr) -> Any:
        if isinstance(node, ast.Name):
            return self._of_name.get(node.id)
        if isinstance(node, ast.Attribute):
            return getattr(self.of(node.value), "__annotations__", {}).get(node.attr)
        if not isinstance(node, ast.Call):
            return None
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self.of(node.func.value)
        function = self._value(node.func)
        if isinstance(function, FunctionType):
            return function.__annotations__.get("return")
        return _tuple_kind(function)

    def named(self, target: ast.expr, value: ast.expr) -> dict[str, Any]:
        """Return the types of the names that an assignment gives."""
        if isinstance(target, ast.Name):
            return {target.id: self._annotation(value)}
        if not isinstance(target, ast.Tuple):
            return {}
        if isinstance(value, ast.Tuple):
            kinds = [self._annotation(each) for each in value.elts]
        else:
            kinds = [*get_args(self._annotation(value))]
        kinds = kinds if len(kinds) == len(target.elts) else [None] * len(target.elts)
        names = zip(target.elts, kinds, strict=True)
        return {name.id: kind for name, kind in names if isinstance(name, ast.Name)}

    def update(self, known: dict[str, Any]) -> None:
        """Take over the types of names."""
        self._of_name |= known


class _Replacing(dict[type, Any]):
    """Functions that replace fields of a NamedTuple, by its type; made when first asked for."""

    def __init__(self, names: tuple[str, ...]) -> None:
        super().__init__()
        self._names = names

    def __missing__(self, kind: Any) -> Any:
        fields = [
            name if name in self._names else f"s_[{i}]" for i, name in enumerate(kind._fields)
        ]
        text = f"lambda s_, {', '.join(self._names)}: new_(kind_, ({', '.join(fields)},))"
        self[kind] = eval(text, {"new_": tuple.__new__, "kind_": kind})  # names of fields
        return self[kind]


replacing = cache(_Replacing)  # (names of fields): (s, their values) -> s, by the type of s
