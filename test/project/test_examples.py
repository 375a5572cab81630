# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The examples of the pages run as they stand."""

import re
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    plt.close("all")


def test_python_page_runs_from_top_to_bottom(folder, capsys):
    text = (ROOT / "docs" / "python.md").read_text("utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == 5
    names = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    said = capsys.readouterr().out
    assert "Stable: " in said and "link.up.delay_s = -0.01: must be 0..60 s" in said
    forces = list(names["forces"].values())
    assert forces == sorted(forces, reverse=True) and forces[-1] > 0.1  # softer over a delay
    made = {str(path.relative_to(folder)) for path in folder.rglob("*.*")}
    assert {"carry.png", "figures/positions.svg", "sessions/mine/session.mat"} <= made
    assert {"sessions/mine/csv/user1.csv", "sessions/mine/session.h5"} <= made
