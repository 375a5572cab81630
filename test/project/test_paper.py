# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The paper has the numbers that ``make paper`` measured, and every figure."""

import re

from paper.__main__ import FIGURES
from paper.drawing import IMAGES
from paper.numbers import BLOCK, PAGE, inserted, read

TEXT = PAGE.read_text("utf-8")


def test_the_tables_of_the_paper_are_those_that_were_measured():
    assert inserted(TEXT, read()) == TEXT, "run make paper"
    assert {found[1] for found in BLOCK.findall(TEXT)} == set(FIGURES)


def test_a_number_changed_by_hand_is_found():
    tables = read()
    name = next(iter(tables))
    tables[name][-1][-1] += "9"
    assert inserted(TEXT, tables) != TEXT


def test_the_paper_shows_every_figure():
    shown = set(re.findall(r"\(images/paper_(\w+)\.svg\)", TEXT))
    assert shown == set(FIGURES)
    assert all((IMAGES / f"paper_{name}.svg").exists() for name in shown)
