# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The definitions of a source tree that nothing in it leads to, found from its text.

A function or class at the top of a module is used when code that runs on import, an entry point
(``package.module:name`` in a text) or another used definition names it; ``getattr(module, ...)``
names all of a module. Methods and properties are told by name only: one attribute of that name,
anywhere or in a template, keeps them.
"""

import ast
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

ENTRY_POINT = re.compile(r"([\w.]+):(\w+)")
TEMPLATES = {".html", ".j2"}
# Decorators that leave a definition where it is; any other one registers it somewhere.
PLAIN = {
    "abstractmethod", "cache", "cached_property", "classmethod", "contextmanager", "dataclass",
    "lru_cache", "overload", "property", "runtime_checkable", "staticmethod", "wraps",
}  # fmt: skip
Name = tuple[str, str]  # module, name in it


class Definition(NamedTuple):
    """A function, class or method: ``where`` is ``package.module:name``."""

    where: str
    lines: int


class _Module:
    """One file: its imports, its definitions and the names that each part of it uses."""

    def __init__(self, file: Path, name: str) -> None:
        self.name = name
        self.tree = ast.parse(file.read_text("utf-8"))
        self.imported: dict[str, Name] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    self.imported[alias.asname or alias.name] = (str(node.module), alias.name)
            elif isinstance(node, ast.Import):
                for alias in node.names:
                    bound = alias.name if alias.asname else alias.name.split(".")[0]
                    self.imported[alias.asname or bound] = (bound, "")
        self.definitions: dict[str, ast.FunctionDef | ast.ClassDef] = {
            node.name: node
            for node in self.tree.body
            if isinstance(node, ast.FunctionDef | ast.ClassDef)
        }

    def at_import(self) -> Iterator[Name]:
        """Yield the names that run when the module is imported."""
        for node in self.tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                for decorator in node.decorator_list:
                    yield from self.uses(decorator)
                    if _last_name(decorator) not in PLAIN:
                        yield self.name, node.name
            else:
                yield from self.uses(node)

    def uses(self, part: ast.AST) -> Iterator[Name]:
        """Yield module and name of everything that a part of the file names."""
        for node in ast.walk(part):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                yield self.imported.get(node.id, (self.name, node.id))
            elif isinstance(node, ast.Attribute):
                yield self._attribute(node)
            elif isinstance(node, ast.Call) and ast.unparse(node.func) == "getattr":
                yield ".".join(filter(None, self.imported.get(ast.unparse(node.args[0]), ()))), "*"
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield from ENTRY_POINT.findall(node.value)

    def _attribute(self, node: ast.Attribute) -> Name:
        """Return ``module.name`` as module and name; any other attribute has no module."""
        dotted = ast.unparse(node.value)
        head, _, rest = dotted.partition(".")
        if head in self.imported and re.fullmatch(r"[\w.]+", dotted):
            return ".".join(filter(None, (*self.imported[head], rest))), node.attr
        return "", node.attr

    def methods(self) -> Iterator[tuple[str, ast.FunctionDef]]:
        """Yield ``Class.method`` with its definition, but for names like ``__eq__`` and what a
        base class of another library calls.
        """
        for name, node in self.definitions.items():
            if isinstance(node, ast.ClassDef) and not any(map(self._is_external, node.bases)):
                for part in node.body:
                    if isinstance(part, ast.FunctionDef) and not part.name.startswith("__"):
                        yield f"{name}.{part.name}", part

    def _is_external(self, base: ast.expr) -> bool:
        """Return whether a base class is of a library that is no part of the tree."""
        package = self.imported.get(ast.unparse(base).partition(".")[0], ("", ""))[0]
        return package.split(".")[0] not in ("", "typing", "enum", self.name.split(".")[0])


def unused(root: Path, sources: Sequence[Path], others: Sequence[Path] = ()) -> list[Definition]:
    """Return the definitions of ``sources`` that neither they nor ``others`` lead to.

    The name of a module is its path below ``root``, or below the folder of its distribution (the
    one with ``setup.py``). Everything that ``others`` name is used.
    """
    modules = {m.name: m for m in map(_parser(root), _python(sources))}
    exports = {
        (module.name, local): target
        for module in modules.values()
        for local, target in module.imported.items()
        if target != (module.name, local)  # a package that imports its own modules
    }
    waiting = [name for module in modules.values() for name in module.at_import()]
    for module in map(_parser(root), _python(others)):
        waiting += module.uses(module.tree)
    texts = [f.read_text("utf-8") for f in (*sources, *others) if f.suffix in TEMPLATES]
    attributes = {word for text in texts for word in re.findall(r"\w+", text)}
    used: set[Name] = set()
    while waiting:
        name = waiting.pop()
        followed = set()
        while name in exports and name not in followed:
            followed.add(name)
            name = exports[name]
        attributes.add(name[1])
        if name not in used:
            used.add(name)
            module = modules.get(name[0])
            if module and name[1] == "*":
                waiting += [(module.name, each) for each in module.definitions]
            elif module and name[1] in module.definitions:
                waiting += module.uses(module.definitions[name[1]])
    found = []
    for module in modules.values():
        for name, node in module.definitions.items():
            if (module.name, name) not in used:
                found.append(_definition(module, name, node))
        for name, node in module.methods():
            if node.name not in attributes and (module.name, name.split(".")[0]) in used:
                found.append(_definition(module, name, node))
    return found


def _definition(module: _Module, name: str, node: ast.FunctionDef | ast.ClassDef) -> Definition:
    return Definition(f"{module.name}:{name}", (node.end_lineno or node.lineno) - node.lineno + 1)


def _last_name(decorator: ast.expr) -> str:
    """Return ``name`` of ``@module.name(...)``."""
    target = decorator.func if isinstance(decorator, ast.Call) else decorator
    return target.attr if isinstance(target, ast.Attribute) else getattr(target, "id", "")


def _python(files: Sequence[Path]) -> list[Path]:
    return [file for file in files if file.suffix not in TEMPLATES]


def _parser(root: Path) -> Callable[[Path], _Module]:
    """Return what reads one file of a tree."""

    def parse(file: Path) -> _Module:
        home = next((p for p in file.parents if (p / "setup.py").exists()), root)
        parts = file.relative_to(home).with_suffix("").parts
        return _Module(file, ".".join(part for part in parts if part != "__init__"))

    return parse
