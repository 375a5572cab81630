# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The examples of the pages run as they stand."""

import json
import re
import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from pmwvc_bringup import scenarios
from pmwvc_core.simulation.session import simulate_one

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
    assert "Stable: " in said and "link.delay_s = -0.01: must be 0..60 s" in said
    forces = list(names["forces"].values())
    assert forces == sorted(forces, reverse=True) and forces[-1] > 0.1  # softer over a delay
    made = {str(path.relative_to(folder)) for path in folder.rglob("*.*")}
    assert {"carry.png", "figures/positions.svg", "sessions/mine/session.mat"} <= made
    assert {"sessions/mine/csv/user1.csv", "sessions/mine/session.mat"} <= made


@pytest.mark.parametrize("name", ["wave_line", "recorded_session"])
def test_notebook_runs_from_top_to_bottom(folder, capsys, name):
    content = json.loads((ROOT / "docs" / "notebooks" / f"{name}.ipynb").read_text("utf-8"))
    cells = ["".join(cell["source"]) for cell in content["cells"] if cell["cell_type"] == "code"]
    assert len(cells) > 5
    names = {}
    for number, cell in enumerate(cells, start=1):
        exec(compile(cell, f"{name}.ipynb, code cell {number}", "exec"), names)
    said = capsys.readouterr().out
    assert {"wave_line": "largest difference", "recorded_session": "carry_16ms: simulated"}[
        name
    ] in said
    assert len(plt.get_fignums()) == {"wave_line": 1, "recorded_session": 2}[name]
    assert not any(cell.get("outputs") for cell in content["cells"])  # small, and never stale


def test_every_controller_of_the_bench_still_has_a_scenario():
    names = runpy.run_path(str(ROOT / "test" / "bench" / "controllers.py"))
    assert all(names["scenario_of"](settings) for settings in names["CASES"].values())
    assert names["scenario_of"](names["MATRIX"]).dof == 3


def test_the_least_scenario_of_a_scene_runs_as_its_page_has_it(folder):
    page = (ROOT / "docs" / "environments.md").read_text("utf-8")
    blocks = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    (text,) = (block for block in blocks if "mine.xml" in block)
    (folder / "mine.yaml").write_text(text)
    scene = scenarios.known()["lift"].parent / "scenes" / "lift.xml"
    (folder / "mine.xml").write_bytes(scene.read_bytes())
    scenario = scenarios.load("mine.yaml", duration_s=7.5)
    height_m = simulate_one(scenario).server.poses["box"][:, 2]
    assert scenario.name == "mine" and height_m.max() > height_m[0] + 0.01
