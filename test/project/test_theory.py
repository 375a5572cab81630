# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every equation of ``docs/theory.md`` has a number and a home, and its home cites the number."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "theory.md").read_text("utf-8")
ROW = re.compile(r"^\| (\d+\.\d+) \| (.+) \| `([^`]+)` \|$", re.MULTILINE)
HOMES = {number: home for number, _, home in ROW.findall(TEXT)}
CITATION = re.compile(r"theory\.md,?\s+(\d+\.\d+(?:(?:,|\s+and|\s+to)\s+\d+\.\d+)*)")
REFERENCE = re.compile(r"\(([1-9]\d*\.\d+(?:(?:,| and| to) \d+\.\d+)*)(?=[);,:])")
# A relation whose right side is no plain number: `b = 25 N s/m` is a value, `F = b xd` a law.
EQUATION = re.compile(
    r"(?<=[\w)\]}|'^+]) (?:=|<=|>=|<-|\+=|-=)\s"
    r"(?:[^-+\d\s.]|[-+][^\d\s.]|[-+]?[\d.]+(?:\(| ?(?:pi|sqrt|[b-ln-rt-zA-IK-MO-VX-Z](?!\w))))"
)


def numbers(text):
    """Return the numbers that a list of them names; ``3.1 to 3.3`` are three."""
    found = []
    for number in re.finditer(r"(to )?(\d+)\.(\d+)", text):
        section, last = int(number[2]), int(number[3])
        first = int(found[-1].split(".")[1]) + 1 if number[1] else last
        found += [f"{section}.{index}" for index in range(first, last + 1)]
    return found


def cited(text):
    """Return the numbers of equations that a source file cites."""
    return {number for match in CITATION.finditer(text) for number in numbers(match[1])}


def file_of(home):
    """Return the file of a home: a path, or a module of the core or of the analysis."""
    module = home.partition(":")[0]
    if module.endswith(".py"):
        return ROOT / module
    inside = Path(*module.split("."))
    found = [
        file
        for package in ("pmwvc_core", "pmwvc_analysis")
        for path in (ROOT / package / package / inside, ROOT / package / inside)
        for file in (path.with_suffix(".py"), path / "__init__.py")
        if file.is_file()
    ]
    assert len(found) == 1, f"{home}: {found}"
    return found[0]


def named_in(file):
    tree = ast.parse(file.read_text("utf-8"))
    targets = [t for n in tree.body if isinstance(n, ast.Assign) for t in n.targets]
    return {n.name for n in tree.body if hasattr(n, "name")} | {
        target.id for target in targets if isinstance(target, ast.Name)
    }


def unnumbered(text):
    """Yield the paragraphs and rows that hold an equation and refer to no number."""
    for block in re.split(r"\n\n|\n(?=\||\* )", text):
        if EQUATION.search(block) and not ROW.match(block) and not REFERENCE.search(block):
            yield block.strip()


def test_numbers_follow_one_another_within_each_section():
    assert len(HOMES) > 90
    for section in re.split(r"^## ", TEXT, flags=re.MULTILINE)[1:]:
        number = section.partition(".")[0]
        found = [row[0] for row in ROW.findall(section)]
        assert found == [f"{number}.{index}" for index in range(1, len(found) + 1)]


@pytest.mark.parametrize("number", HOMES)
def test_home_of_an_equation_exists_and_cites_it(number):
    home = HOMES[number]
    file = file_of(home)
    assert file.is_file(), f"theory.md {number}: no file for {home}"
    name = home.partition(":")[2]
    assert not name or name in named_in(file), f"theory.md {number}: no {name} in {file.name}"
    assert number in cited(file.read_text("utf-8")), f"{file} does not cite theory.md {number}"


def test_every_citation_of_an_equation_leads_to_its_home():
    for file in sorted(ROOT.glob("pmwvc_*/pmwvc_*/**/*.py")):
        for number in cited(file.read_text("utf-8")):
            assert number in HOMES, f"{file} cites theory.md {number}"
            assert file_of(HOMES[number]) == file, f"{file} cites {number} of {HOMES[number]}"


def test_no_equation_is_without_a_number_and_one_without_is_found():
    # Section 16 is a list of misprints: how they are published, and how they are read.
    prose = re.sub(r"^## 16\..*?(?=^## )", "", TEXT, flags=re.MULTILINE | re.DOTALL)
    assert "## 15." in prose and "## 17." in prose
    assert list(unnumbered(prose)) == []
    referred = {n for match in REFERENCE.finditer(TEXT) for n in numbers(match[1])}
    assert referred <= set(HOMES)
    assert list(unnumbered("The port has v = u - sqrt(2/b) F.\n\nWith b = 25 it is 3 N."))
    assert not list(unnumbered("The port has v = u - sqrt(2/b) F (1.3)."))
    assert not list(unnumbered("With b = 25, K = 500 N/m and T = 20 ms it holds."))
    cites = cited("see docs/theory.md 3.1, 4.2 and 5.1 to 5.3")
    assert cites == {"3.1", "4.2", "5.1", "5.2", "5.3"}
