# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packages of another laboratory: the examples of the documentation, installed in a folder, and
modules that seem to be installed.
"""

import contextlib
import json
import os
import re
import subprocess
import sys
import types
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from pathlib import Path

from support.command_line import ROOT


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


COMMANDS = """
import json, sys
from support.command_line import here
for line in sys.stdin:
    done = here(*json.loads(line), cwd=".")
    print(json.dumps([done.returncode, done.stdout, done.stderr]), flush=True)
"""


@contextlib.contextmanager
def example_of(folder, page):
    """Install the example of a page of docs/; yield the command line beside it, whose commands
    all run in one process: it imports, and unrolls the laws, once.
    """
    text, source = source_of(page)
    [(group, point)] = re.findall(r'entry-points\."(.*?)"\]\n(.*)', text)
    module = re.search(r'"(\w+):', point)[1]
    install(folder, module, source, {group: point})
    path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", ""), *sys.path])
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "cwd": folder}
    program, environment = [sys.executable, "-c", COMMANDS], os.environ | {"PYTHONPATH": path}
    with subprocess.Popen(program, env=environment, **pipes) as process:

        def run(*words):
            print(json.dumps([*map(str, words)]), file=process.stdin, flush=True)
            code, out, error = json.loads(process.stdout.readline())
            return subprocess.CompletedProcess(words, code, out, error)

        yield run
        process.stdin.close()


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
