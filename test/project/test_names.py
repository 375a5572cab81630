# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Names: a class has its own, and no code compares those of controllers, couplings, compensations,
environments and link effects, which are asked for their properties.
"""

import ast
from pathlib import Path

from pmwvc_core.controllers.library import LIBRARY as CONTROLLERS
from pmwvc_core.network.effects import EFFECTS
from pmwvc_core.server.couplings import COMPENSATIONS, COUPLINGS
from pmwvc_core.server.environments import LIBRARY as ENVIRONMENTS

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = [file for folder in ROOT.glob("pmwvc_*") for file in folder.glob("pmwvc_*/**/*.py")]
KINDS = (CONTROLLERS, COUPLINGS.library, COMPENSATIONS.library, ENVIRONMENTS, EFFECTS.library)
# Names of other things too: of filters and feedbacks, and of what a packet met.
SHARED = {"none", "printed", "duplication", "delay", "loss", "order"}
NAMES = {name for kind in KINDS for name in kind} - SHARED
OWN = {  # files whose names are those of something else
    "characteristic.py": {"unwrapped", "one_step_delay"}  # polynomials
}


def compared_names(file):
    """Yield the names that a file compares something with."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Compare):
            for leaf in ast.walk(node):
                if isinstance(leaf, ast.Constant) and leaf.value in NAMES:
                    if leaf.value not in OWN.get(file.name, ()):
                        yield f"{file.name}:{node.lineno} {leaf.value}"


def test_no_code_compares_the_name_of_what_has_a_record():
    assert len(PRODUCT) > 300
    assert [found for file in PRODUCT for found in compared_names(file)] == []


def test_a_comparison_with_a_name_is_found(tmp_path):
    file = tmp_path / "bad.py"
    file.write_text("def f(name):\n    return name == 'tdpa' or name in ('implicit', 'x')\n")
    assert list(compared_names(file)) == ["bad.py:2 tdpa", "bad.py:2 implicit"]


def classes_of(files):
    """Return the files that define each class, by its name."""
    found = {}
    for file in files:
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.ClassDef):
                found.setdefault(node.name, []).append(file.name)
    return found


def test_a_name_of_a_class_is_used_once():
    twice = {name: files for name, files in classes_of(PRODUCT).items() if len(files) > 1}
    assert twice == {}
