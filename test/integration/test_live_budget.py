# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget of a really recorded session."""

import json

import pytest
from support.sessions import Running

pytestmark = pytest.mark.integration


def test_the_budget_of_a_live_session_closes(tmp_path):
    folder = tmp_path / "session"
    with Running(folder, "wall", "--duration", 4) as session:
        assert session.end() == 0, session.said()
    found = json.loads((folder / "budget.json").read_text("utf-8"))
    assert found["closes"], found
    assert found["hands_j"] > 1e-4  # the hand has pressed
    if not found["notes"]:  # nothing is missing: to rounding, as in virtual time
        assert found["residual_largest_j"] < 1e-9
    assert "Energy budget" in (folder / "report.html").read_text("utf-8")
