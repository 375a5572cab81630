# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The live page's colours are those of all figures, light and dark."""

import re

import pytest

from pmwvc_analysis.charts.style import DARK, LIGHT
from pmwvc_view.web.access import PAGE

SHARED = [
    *(f"u{index}" for index in range(8)),
    "object",
    "target",
    "alarm",
    "paper",
    "ink",
    "soft",
]


@pytest.mark.parametrize(("block", "colours"), [(0, LIGHT), (1, DARK)], ids=["light", "dark"])
def test_page_has_colours_of_figures(block, colours):
    style = (PAGE / "page.css").read_text("utf-8")
    blocks = re.findall(r":root \{(.*?)\}", style, re.DOTALL)
    found = dict(re.findall(r"--(\w+): (#\w+);", blocks[block]))
    assert {name: found[name] for name in SHARED} == {name: colours[name] for name in SHARED}
