# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The product's code is named in the field's words (docs/notation.md), not in those of people or
of a theatre: a session reports, it does not tell; a port is not a seat.
"""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = [file for folder in ROOT.glob("pmwvc_*") for file in folder.glob("pmwvc_*/**/*.py")]
INSTEAD = {  # word: better
    **dict.fromkeys(("told", "tells", "say", "says", "said"), "text, reported"),
    **dict.fromkeys(("hear", "hears", "feels"), "receives, rendered"),
    **dict.fromkeys(("seat", "seats"), "port, user"),
    **dict.fromkeys(("lane", "lanes"), "link"),
    **dict.fromkeys(("rival", "rivals"), "baseline"),
    **dict.fromkeys(("trouble", "dying"), "fault, ending"),
    **dict.fromkeys(("surplus", "booked"), "excess, accounted"),
    **dict.fromkeys(("surely", "aside", "nobody"), "a noun with a unit"),
    "agenda": "schedule",
    "calm": "inactive",
    "foreign": "plug-in",
    "hyperframe": "hyperperiod",
}


def wrong_names(file):
    """Yield the names that a file defines with such a word in them."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            name = node.name
        elif isinstance(node, ast.arg):
            name = node.arg
        elif isinstance(node, (ast.Name, ast.Attribute)) and isinstance(node.ctx, ast.Store):
            name = node.id if isinstance(node, ast.Name) else node.attr
        else:
            continue
        for word in INSTEAD.keys() & set(name.lower().split("_")):
            yield f"{file.name}:{node.lineno} {name}: {INSTEAD[word]}"


def test_names_are_in_the_words_of_the_field():
    assert len(PRODUCT) > 300
    assert [found for file in PRODUCT for found in wrong_names(file)] == []


def test_a_name_in_another_word_is_found(tmp_path):
    file = tmp_path / "bad.py"
    file.write_text("TOLD = 1\n\ndef share_of(seat):\n    self._surplus = seat\n")
    assert list(wrong_names(file)) == [
        "bad.py:1 TOLD: text, reported",
        "bad.py:3 seat: port, user",
        "bad.py:4 _surplus: excess, accounted",
    ]
