# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packages of another laboratory: the examples of the documentation, installed in a folder."""

import os
import re

from support.command_line import ROOT, call
from support.installed import install


def example_of(folder, page):
    """Install the example of a page of docs/; return the command line beside it."""
    text = (ROOT / "docs" / page).read_text("utf-8")
    [source] = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    [(group, point)] = re.findall(r'entry-points\."(.*?)"\]\n(.*)', text)
    module = re.search(r'"(\w+):', point)[1]
    install(folder, module, source, {group: point})

    def run(*words):
        path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
        return call(*words, cwd=folder, PYTHONPATH=path)

    return run
