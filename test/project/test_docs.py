# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The documentation names what exists; the page of parameters states what the checks know."""

import importlib.util
import re
from dataclasses import fields
from pathlib import Path

import pytest
from write_reference import group_table

from pmwvc_bringup.scenarios import known
from pmwvc_core.params import LinkParams, MasterParams, SafetyParams
from pmwvc_core.params.names import leaves
from pmwvc_core.scenario.scenario import PARAMETERS
from pmwvc_core.traces import ServerTraces, UserTraces

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), ROOT / "test" / "README.md"])


def test_the_page_of_parameters_is_what_their_dataclasses_give():
    spec = importlib.util.spec_from_file_location("page", ROOT / "tools" / "write_reference.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    page = (ROOT / "docs" / "parameters.md").read_text("utf-8")
    assert page == module.parameters_page(), "run make docs"


def anchors(page):
    """Return the anchors of a page's headings, as a forge makes them."""
    text = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return [re.sub(r"[^\w\- ]", "", each.lower()).replace(" ", "-") for each in headings]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_between_pages_lead_to_a_file_and_a_heading(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8")):
        name, _, anchor = target.partition("#")
        if "://" not in target:
            file = page.parent / name if name else page
            assert file.exists(), target
            assert not anchor or anchor in anchors(file), target


def test_the_readme_names_every_scenario_and_every_document():
    text = (ROOT / "README.md").read_text("utf-8")
    for name in known():
        assert f"`{name}`" in text
    for page in (ROOT / "docs").glob("*.md"):
        assert f"docs/{page.name}" in text


def test_the_table_of_invariants_names_tests_that_exist():
    rows = (ROOT / "test" / "README.md").read_text("utf-8").splitlines()
    for row in rows:
        folder = ""
        for name in re.findall(r"`([\w/]+\.py)`", row):
            folder = name.rpartition("/")[0] or folder
            assert (ROOT / "test" / folder / name.rpartition("/")[2]).is_file(), name


def test_the_notation_names_signals_and_parameters_that_exist():
    text = (ROOT / "docs" / "notation.md").read_text("utf-8")
    signals, _, rest = text.partition("## Parameters")
    traced = {field.name for kind in (UserTraces, ServerTraces) for field in fields(kind)}
    rows = [row for row in signals.splitlines() if row.startswith("|")]
    named = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    assert named - traced == {"u_tx", "v_rx"}  # in packets, not in traces
    parameters = re.findall(r"`([a-z]+\.[\w.]+)`", rest.partition("## Glossary")[0])
    assert set(parameters) <= set(PARAMETERS)


SECTIONS = {
    "master": MasterParams,
    "safety": SafetyParams,
    "link.up": LinkParams,
    "link.down": LinkParams,
}


def rows_of(table):
    """Return the cells of each row, and whether it has a star, by the name in the first."""
    lines = [line for line in table.splitlines() if line.startswith("| `")]
    cells = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]
    star = "\\*"
    return {r[0].removesuffix(star).strip("`"): [*r[1:], r[0].endswith(star)] for r in cells}


@pytest.mark.parametrize("prefix", SECTIONS)
def test_every_parameter_has_a_row_with_its_range_unit_and_description(prefix):
    kind = SECTIONS[prefix]
    rows = rows_of(group_table(prefix, kind))
    named = {name.removeprefix(f"{prefix}."): spec for name, spec in leaves(prefix, kind).items()}
    assert list(rows) == list(named)
    for name, spec in named.items():
        default, allowed, description, starred = rows[name]
        assert spec.range_text() in (allowed.removesuffix(", whole"), f"one of {allowed}")
        assert (default == "null") == (spec.default is None)
        assert allowed.endswith(", whole") == (spec.kind is int)
        assert (description, starred) == (spec.description, spec.read_only)
