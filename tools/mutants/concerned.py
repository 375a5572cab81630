# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The tests that concern a file: those that reach it by imports, the nearest first."""

import ast
import functools
from pathlib import Path

FOLDERS = ("unit", "law", "property", "oracle")  # without processes or a browser
FARTHEST = 4  # imports from a test to the file
# Whole ends and sessions, the quickest first: they come behind the unit tests of a file.
ENDS = ("test_hostile_packets", "test_settled_changes", "test_strict_ends")


def concerned_tests(root: Path, changed: Path) -> list[str]:
    """Return the tests that a file of a tree concerns, relative to the tree."""
    tests = [path for each in FOLDERS for path in sorted(root.glob(f"test/{each}/**/test_*.py"))]
    away = {test: _away(root, test, changed) for test in tests}
    tests = [test for test in tests if away[test] <= FARTHEST]
    ends = [test for name in ENDS for test in tests if test.stem == name]
    tests.sort(key=lambda test: away[test])
    near = [test for test in tests if away[test] <= 1 and test.parts[-2] == FOLDERS[0]]
    tests = list(dict.fromkeys(near + ends + tests))
    return [str(test.relative_to(root)) for test in tests]


def _away(root: Path, test: Path, changed: Path) -> int:
    """Return how many imports lead from a test to a file."""
    seen, edge = {test}, {test}
    for steps in range(FARTHEST + 1):
        if changed in edge:
            return steps
        edge = {found for path in edge for found in _imports(root, path)} - seen
        seen |= edge
    return FARTHEST + 1


@functools.cache
def _imports(root: Path, path: Path) -> frozenset[Path]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{each.name}" for each in node.names)}
    return frozenset(file for name in names if (file := _file(root, name)) is not None)


def _file(root: Path, name: str) -> Path | None:
    top, *rest = name.split(".")
    place = (root / top / top if top.startswith("pmwvc_") else root / "test" / top).joinpath(*rest)
    files = (place.with_suffix(".py"), place / "__init__.py")
    return next((file for file in files if file.exists()), None)
