# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reference page states of every parameter what the checks know of it."""

import subprocess
import sys
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
    """Return the cells of each row by the name in the first."""
    lines = [line for line in table.splitlines() if line.startswith("| `")]
    cells = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]
    return {row[0].strip("`"): row[1:] for row in cells}


def test_a_row_has_default_range_with_unit_and_description():
    rows = rows_of(group_table("master", MasterParams))
    assert rows["impedance"] == ["25", "0.01..1000 N s/m", "wave impedance b"]
    assert rows["rate_drop"][1] == "1..1000, whole"


@pytest.mark.parametrize("prefix", SECTIONS)
def test_every_parameter_has_a_row_with_its_range(prefix):
    kind = SECTIONS[prefix]
    rows = rows_of(group_table(prefix, kind))
    named = {name.removeprefix(f"{prefix}."): spec for name, spec in leaves(prefix, kind).items()}
    assert list(rows) == list(named)
    for name, spec in named.items():
        assert spec.range_text() in (
            rows[name][1].removesuffix(", whole"),
            f"one of {rows[name][1]}",
        )
        assert (spec.unit or "-") in ("-", "") or spec.unit in rows[name][1]
        assert rows[name][2].startswith(spec.description)


def test_nested_groups_defaults_and_fixed_ones_are_reported():
    rows = rows_of(group_table("master", MasterParams))
    assert rows["filter.pole_rad_s"][0] == "null"
    assert rows["filter.kind"][0] == "integrate_and_dump"
    assert rows["tick_s"][2].endswith("; fixed")
    assert rows_of(group_table("link.up", LinkParams))["keep_order"][0] == "true"


def test_groups_that_share_their_parameters_share_a_section():
    page = reference_page(SECTIONS)
    assert [line for line in page.splitlines() if line.startswith("## ")] == [
        "## `master`",
        "## `safety`",
        "## `link.up`, `link.down`",
    ]
    assert page.count("`delay_s`") == 1


def test_a_parameter_without_default_is_required():
    table = docs_table(
        {"users": Spec(int, low=1, high=8, default=NO_DEFAULT), "name": Spec(str, default="")}
    )
    assert rows_of(table)["users"][:2] == ["(required)", "1..8, whole"]
    assert rows_of(table)["name"][0] == '""'


def test_a_bar_in_a_text_does_not_end_the_cell():
    table = docs_table({"a": Spec(str, description="x|y\nz", default="p|q")})
    assert rows_of(table)["a"][2] == "x\\|y z"
    assert rows_of(table)["a"][0] == "p\\|q"


def test_the_page_needs_no_ros():
    code = (
        "import sys\n"
        f"sys.path.insert(0, {str(TOOLS)!r})\n"
        "for name in ('rclpy', 'rcl_interfaces'): sys.modules[name] = None\n"
        "from write_reference import parameters_page\n"
        "print(parameters_page())\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60
    )
    assert result.returncode == 0, result.stderr
    assert "`impedance`" in result.stdout
