# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packages of another laboratory: the examples of the documentation, installed in a folder."""

import os
import re

from support.command_line import ROOT, call


def installed(folder, page):
    """Install the example of a page of docs/; return the command line beside it."""
    text = (ROOT / "docs" / page).read_text("utf-8")
    [source] = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    [points] = re.findall(r"```toml\n\[project\.entry-points\.(.*?)```", text, re.DOTALL)
    group, point = points.replace('"', "").split("]\n")
    module = re.search(r"= (\w+):", point)[1]
    (folder / f"{module}.py").write_text(source)
    metadata = folder / f"{module}-1.0.dist-info"
    metadata.mkdir()
    name = module.replace("_", "-")
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[{group}]\n{point}")

    def run(*words):
        path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
        return call(*words, cwd=folder, PYTHONPATH=path)

    return run
