# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The page on drift says what its result says, and the result is of the scenario it names."""

from pathlib import Path

import pytest
from support.plain import load

from reproduction import pages
from reproduction.files import read
from reproduction.position_drift import FIGURES, HANDS, LINKS, MODEL

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "reproduction"
PAID = ("budgeted", "integral")
FEEDBACKS = ("none", "printed", *PAID)


def test_the_page_is_written_from_the_committed_result():
    page = (FOLDER / "position_drift.md").read_text("utf-8")
    assert page == pages.drift_page(FOLDER), "make figures"


def test_the_scenario_is_carry_16ms():
    given = load("carry_16ms").flat()
    assert {name: given[f"operator.{name}"] for name in HANDS} == HANDS
    assert given["safety.max_force"] == MODEL["safety.max_force"]
    assert given["link.up.delay_s"] == given["link.down.delay_s"] == MODEL["link.delay_s"]
    assert (given["task.kind"], given["users"]) == ("carry", 2)


@pytest.fixture(scope="module")
def short():
    figure = FIGURES[0]
    return figure.compute({**figure.parameters, "feedbacks": FEEDBACKS, "duration_s": 4.0})[
        "numbers"
    ]


@pytest.mark.parametrize("link", LINKS)
def test_who_pays_makes_no_energy_and_who_does_not_makes_some(short, link):
    assert short[f"least_balance_mj_{link}_printed"] < -0.5
    for feedback in PAID:
        assert short[f"least_balance_mj_{link}_{feedback}"] >= -1e-3


@pytest.mark.parametrize("link", LINKS)
def test_the_published_feedback_brings_device_and_avatar_together(short, link):
    without = short[f"end_mm_{link}_none"]
    assert without > 3.0
    assert abs(short[f"end_mm_{link}_printed"]) < 0.3 * without


def test_over_a_minute_the_committed_numbers_are_the_same():
    found = read("position_drift", FOLDER)["numbers"]
    for link in LINKS:
        assert found[f"least_balance_mj_{link}_printed"] < -1.0
        for feedback in PAID:
            assert found[f"least_balance_mj_{link}_{feedback}"] >= -1e-3
