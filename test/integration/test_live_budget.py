# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget of a really recorded session."""

import json

import pytest

pytestmark = pytest.mark.integration


def test_budget_of_a_live_session_closes(carried):
    assert carried.code == 0, carried.output()
    found = json.loads((carried.folder / "budget.json").read_text("utf-8"))
    assert found["closes"], found
    assert found["hands_j"] > 1e-4  # the hands have pressed
    if not found["notes"]:  # nothing is missing: to rounding, as in virtual time
        assert found["residual_largest_j"] < 1e-9
    assert "Energy budget" in (carried.folder / "report.html").read_text("utf-8")
