# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reference page states of every parameter what the checks know of it."""

import pytest
from write_reference import group_table

from pmwvc_core.params import LinkParams, MasterParams, SafetyParams
from pmwvc_core.params.names import leaves

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


@pytest.mark.parametrize("prefix", SECTIONS)
def test_every_parameter_has_a_row_with_its_range_unit_and_description(prefix):
    kind = SECTIONS[prefix]
    rows = rows_of(group_table(prefix, kind))
    named = {name.removeprefix(f"{prefix}."): spec for name, spec in leaves(prefix, kind).items()}
    assert list(rows) == list(named)
    for name, spec in named.items():
        default, allowed, description = rows[name]
        assert spec.range_text() in (allowed.removesuffix(", whole"), f"one of {allowed}")
        assert (default == "null") == (spec.default is None)
        assert allowed.endswith(", whole") == (spec.kind is int)
        assert description == spec.description + "; fixed" * spec.read_only
