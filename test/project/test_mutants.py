# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The defects of ``make mutants``: small, different, and drawn by their seed alone."""

import mutants.__main__ as drawing
from mutants.__main__ import FOLDERS, ROOT, drawn
from mutants.concerned import concerned_tests
from mutants.operators import KINDS, defects

SOURCE = """
LIMIT = 3.0


def law(state, x, b):
    state.x = x
    if x > b and -x < LIMIT:
        state.held += min(x - b, b)
    return times(x, b)
"""
FOUND = {
    "sign, and, or": ("x > b or -x", "and +x <", "min(x + b"),
    "comparison": ("if x < b", "-x > LIMIT"),
    "constant": ("LIMIT = 6.0",),
    "arguments": ("times(b, x)",),
    "min, max": ("max(x - b",),
    "condition": ("if not (x > b and -x < LIMIT)",),
    "statement": ("    pass\n    if", "LIMIT:\n        pass"),
}


def test_every_kind_of_defect_is_put_in_at_every_place():
    assert set(FOUND) == set(KINDS)
    for kind, parts in FOUND.items():
        found = [each.put_into(SOURCE) for each in defects(SOURCE) if each.kind == kind]
        for part, mutant in zip(parts, found, strict=True):
            assert part in mutant
            compile(mutant, kind, "exec")


def test_a_seed_draws_the_same_mutants_and_the_nearest_tests_are_concerned(monkeypatch):
    every = [each.file for each in drawn(10**6, 1)]
    for top, names in FOLDERS.items():
        for name in names:
            assert any(f"{top}/{name}/" in str(file) for file in every)
    monkeypatch.setattr(drawing, "FOLDERS", {"pmwvc_core/pmwvc_core": ("transport",)})
    assert drawn(20, 3) == drawn(20, 3) != drawn(20, 4)
    found = concerned_tests(ROOT, ROOT / "pmwvc_core/pmwvc_core/transport/receiver.py")
    assert "test/unit/test_receiver.py" in found[:3]
