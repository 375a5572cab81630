# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packages of another laboratory: the examples of the documentation, installed in a folder, and
modules that seem to be installed.
"""

import os
import re
import sys
import types
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from pathlib import Path

from support.command_line import ROOT, call


def source_of(page):
    """Return the page of docs/, and the source of the first example on it."""
    text = (ROOT / "docs" / page).read_text("utf-8")
    source = re.findall(r"```python\n(.*?)```", text, re.DOTALL)[0]
    return text, source


def install(folder: Path, module: str, source: str, points: Mapping[str, str]) -> None:
    """Write a module and the entry points of its package.

    ``points`` are texts like ``soft = "lab_soft:SOFT"`` by group of entry points.
    """
    (folder / f"{module}.py").write_text(source, "utf-8")
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir()
    name = module.replace("_", "-")
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = [f"[{group}]\n{point}\n" for group, point in points.items()]
    (info / "entry_points.txt").write_text("\n".join(lines).replace('"', ""))


def example_of(folder, page):
    """Install the example of a page of docs/; return the command line beside it."""
    text, source = source_of(page)
    [(group, point)] = re.findall(r'entry-points\."(.*?)"\]\n(.*)', text)
    module = re.search(r'"(\w+):', point)[1]
    install(folder, module, source, {group: point})

    def run(*words):
        path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
        return call(*words, cwd=folder, PYTHONPATH=path)

    return run


def offer(patch, group, module, found, *, kept=(), **values):
    """Have a module of another package offer objects by name as plug-ins of a group.

    ``values`` are further entry points by name, ``kept`` those that stay besides. Returns all.
    """
    made = types.ModuleType(module)
    vars(made).update(found)
    patch.setitem(sys.modules, module, made)
    values = {name: f"{module}:{name}" for name in found} | values
    points = [*kept, *(EntryPoint(name, value, group) for name, value in values.items())]
    patch.setattr(
        "pmwvc_core.plugins.entry_points",
        lambda group: [point for point in points if point.group == group],
    )
    return points
