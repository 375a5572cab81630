# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The product's code is named in the field's words (docs/notation.md), not in those of people or
of a theatre; a class has its own name, and no code compares those of controllers, couplings,
compensations, environments and link effects.
"""

import ast
import re
from pathlib import Path

from pmwvc_core.controllers.library import LIBRARY as CONTROLLERS
from pmwvc_core.network.effects import EFFECTS
from pmwvc_core.server.couplings import COMPENSATIONS, COUPLINGS
from pmwvc_core.server.environments import LIBRARY as ENVIRONMENTS

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = [file for folder in ROOT.glob("pmwvc_*") for file in folder.glob("pmwvc_*/**/*.py")]
INSTEAD = {  # word: better
    **dict.fromkeys(("told", "tells", "say", "says", "said"), "text, reported"),
    **dict.fromkeys(("hear", "hears", "heard", "unheard", "feels"), "receives, rendered"),
    **dict.fromkeys(("owe", "owes", "owed"), "deficit, undelivered"),
    **dict.fromkeys(("seat", "seats"), "port, user"),
    **dict.fromkeys(("lane", "lanes"), "link"),
    **dict.fromkeys(("rival", "rivals"), "baseline"),
    **dict.fromkeys(("trouble", "dying"), "fault, ending"),
    **dict.fromkeys(("surplus", "booked"), "excess, accounted"),
    **dict.fromkeys(("surely", "aside", "nobody"), "a noun with a unit"),
    "agenda": "schedule",
    "calm": "inactive",
    "debt": "deficit",
    "foreign": "plug-in",
    "hyperframe": "hyperperiod",
}

PAGE = sorted((ROOT / "pmwvc_view" / "pmwvc_view" / "page").glob("*.js"))
TEXTS = {  # in what the program prints: better
    r"\bfe(el|els|lt) like\b": "acts like, rendered",
    r"\b(tell|tells|told|say|says|said)\b": "gives, reports, has",
    r"\b(hear|hears|heard)\b": "receives",
    r"\b(nobody|somebody)\b": "no user, another page",
    r"\bpays? for nothing\b": "generates energy",
    r"\btakes? \w+ \w+ for gone\b": "counts as silent",
    r"\btrembl(e|es|ing)\b": "chatters, oscillates",
    r"\b(yours|mine)\b": "held by this page",
    r"\bmust be a (list of )?texts?\b": "string",
}


def texts(file):
    """Yield line and text of what a file may print: its strings without docstrings, or its
    templates where it is a page's.
    """
    source = file.read_text("utf-8")
    if file.suffix == ".js":
        for number, line in enumerate(source.split("\n"), start=1):
            yield from ((number, text) for text in re.findall(r"""[`"]([^`"]*)[`"]""", line))
        return
    tree = ast.parse(source)
    docstrings = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))
        and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            if id(node) not in docstrings and " " in node.value:
                yield node.lineno, node.value


def wrong_texts(file):
    """Yield the texts of a file with such a word in them."""
    for number, text in texts(file):
        for pattern, better in TEXTS.items():
            if re.search(pattern, text):
                yield f"{file.name}:{number} {text}: {better}"


def wrong_names(file):
    """Yield the names that a file defines with such a word in them."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        stored = isinstance(getattr(node, "ctx", None), ast.Store)
        if isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.arg)) or stored:
            found = (getattr(node, field, None) for field in ("name", "arg", "id", "attr"))
            name = next(filter(None, found), "")
            for word in INSTEAD.keys() & set(name.lower().split("_")):
                yield f"{file.name}:{node.lineno} {name}: {INSTEAD[word]}"


def test_names_and_texts_are_in_the_words_of_the_field():
    assert len(PRODUCT) > 300 and len(PAGE) > 10
    assert [found for file in PRODUCT for found in wrong_names(file)] == []
    assert [found for file in [*PRODUCT, *PAGE] for found in wrong_texts(file)] == []


def test_names_and_texts_in_other_words_are_found(tmp_path):
    file, page = tmp_path / "bad.py", tmp_path / "bad.js"
    file.write_text(
        '"""The told one."""\nTOLD = 1\n\ndef share_of(seat):\n    self._surplus = seat\n'
        'print(f"the cube feels like {1} N/m")\n'
    )
    page.write_text("const text = `the cube feels like ${x} N/m`;")
    assert list(wrong_names(file)) == [
        "bad.py:2 TOLD: text, reported",
        "bad.py:4 seat: port, user",
        "bad.py:5 _surplus: excess, accounted",
    ]
    for each in (file, page):
        (found,) = wrong_texts(each)
        assert "the cube feels like" in found and "acts like" in found


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
