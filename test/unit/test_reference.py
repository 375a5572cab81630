# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reference page states of every parameter what the checks know of it."""

from pathlib import Path

import pytest
from write_reference import docs_table, group_table, reference_page

from pmwvc_core.params import LinkParams, MasterParams, SafetyParams, Spec
from pmwvc_core.params.fields import NO_DEFAULT
from pmwvc_core.params.names import leaves

TOOLS = Path(__file__).resolve().parents[2] / "tools"
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


def test_groups_that_share_their_parameters_share_a_section():
    page = reference_page(SECTIONS)
    assert [line for line in page.splitlines() if line.startswith("## ")] == [
        "## `master`",
        "## `safety`",
        "## `link.up`, `link.down`",
    ]
    assert page.count("`delay_s`") == 1


def test_what_is_required_and_what_holds_a_bar_keep_their_cells():
    count = Spec(int, low=1, high=8, default=NO_DEFAULT)
    barred = Spec(str, description="x|y\nz", default="p|q")
    rows = rows_of(docs_table({"users": count, "a": barred}))
    assert rows["users"][:2] == ["(required)", "1..8, whole"]
    assert (rows["a"][0], rows["a"][2]) == ("p\\|q", "x\\|y z")
