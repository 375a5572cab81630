# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The page on drift says what its result says, and the result is of the scenario it names."""

from pathlib import Path

from support.plain import load

from reproduction import pages
from reproduction.files import read
from reproduction.position_drift import HANDS, LINKS, MODEL

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "reproduction"
PAID = ("budgeted", "integral")


def test_the_page_is_written_from_the_committed_result():
    page = (FOLDER / "position_drift.md").read_text("utf-8")
    assert page == pages.drift_page(FOLDER), "make figures"


def test_the_scenario_is_carry_16ms():
    given = load("carry_16ms").flat()
    assert {name: given[f"operator.{name}"] for name in HANDS} == HANDS
    assert given["safety.max_force"] == MODEL["safety.max_force"]
    assert given["link.up.delay_s"] == given["link.down.delay_s"] == MODEL["link.delay_s"]
    assert (given["task.kind"], given["users"]) == ("carry", 2)


def test_over_a_minute_the_committed_numbers_are_the_same():
    found = read("position_drift", FOLDER)["numbers"]
    for link in LINKS:
        assert found[f"least_balance_mj_{link}_printed"] < -1.0
        for feedback in PAID:
            assert found[f"least_balance_mj_{link}_{feedback}"] >= -1e-3
