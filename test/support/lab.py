# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packages of another laboratory: the examples of the documentation, installed in a folder, and
modules that seem to be installed.
"""

import os
import re
import sys
import types
from importlib.metadata import EntryPoint

from support.command_line import ROOT, call
from support.installed import install


def source_of(page):
    """Return the page of docs/, and the source of the example on it."""
    text = (ROOT / "docs" / page).read_text("utf-8")
    [source] = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    return text, source


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
