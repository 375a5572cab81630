# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The recipes of ``CONTRIBUTING.md``, followed to the letter."""

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support import handmade
from support.command_line import here
from support.lab import install

from pmwvc_analysis.figures import figures
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import commands, scenarios
from pmwvc_bringup.cli import library
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.simulation.session import simulate_one

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
RECIPES = {
    heading: body
    for heading, body in re.findall(
        r"^### An? (.*?)\n(.*?)(?=^##)", TEXT, flags=re.MULTILINE | re.DOTALL
    )
}
PACKAGES = [file.parent for file in sorted(ROOT.glob("*/package.xml"))]


def code(recipe, language="python"):
    """Return the code of a recipe."""
    (text,) = re.findall(rf"```{language}\n(.*?)```", RECIPES[recipe], re.DOTALL)
    return text


def entry_points(recipe):
    """Return group and entry points that a recipe has a package declare."""
    group, points = re.search(r'entry-points\."(.*?)"\]\n(.*)', code(recipe, "toml")).groups()
    return {group: points}


def run(words, **environment):
    return subprocess.run(
        words, env=os.environ | environment, capture_output=True, text=True, check=True
    ).stdout


def test_every_recipe_is_followed_and_of_a_few_lines():
    assert set(RECIPES) >= {
        "scenario", "parameter", "controller", "coupling", "environment", "device", "figure",
        "command", "link effect",
    }  # fmt: skip
    followed = set(
        re.findall(r"^def test_recipe_of_an?_(\w+?)\(", Path(__file__).read_text(), re.M)
    )
    elsewhere = {"controller", "environment", "device", "link_effect"}  # on pages of their own
    assert {recipe.replace(" ", "_") for recipe in RECIPES} == followed | elsewhere
    for recipe, body in RECIPES.items():
        assert len(re.findall(r"^\d\. ", body, re.MULTILINE)) in (3, 4, 5), recipe


@pytest.mark.parametrize(
    ("recipe", "page"),
    [
        ("controller", "controllers.md"),
        ("environment", "environments.md"),
        ("device", "devices.md"),
        ("link effect", "links.md"),
    ],
)
def test_page_with_the_code_of_a_recipe_is_followed_by_its_own_test(recipe, page):
    assert f"docs/{page}" in RECIPES[recipe]
    files = (ROOT / "test" / "unit").glob(f"test_{recipe.replace(' ', '_')}_*.py")
    tests = "".join(file.read_text("utf-8") for file in files)
    assert page in tests and ("```python" in tests or "example_of(" in tests)


def test_every_file_that_the_page_names_exists():
    named = set(re.findall(r"`([\w./]+/[\w.]+)`", TEXT)) | set(re.findall(r"\]\(([^)#]+)", TEXT))
    named = {path for path in named if "NAME" not in path}
    assert len(named) > 20
    roots = [ROOT, *PACKAGES]
    assert [p for p in named if not any((root / p).exists() for root in roots)] == []


def test_recipe_of_a_scenario(tmp_path):
    (tmp_path / "soft_wall.yaml").write_text(code("scenario", "yaml"))
    scenario = scenarios.load(str(tmp_path / "soft_wall.yaml"))
    found = summary(simulate_one(scenario), scenario)
    assert found["scenario"] == "soft_wall"
    assert found["stable"] is True
    (user,) = found["users"]
    assert user["passive"] is True
    assert user["force_final_n"] > 0.1  # the hand rests on it


def test_recipe_of_a_parameter(tmp_path):
    """A copy of the core with the field: reader, check and reference page know it."""
    shutil.copytree(ROOT / "pmwvc_core" / "pmwvc_core", tmp_path / "pmwvc_core")
    file = tmp_path / "pmwvc_core" / "params" / "user.py"
    text, before = file.read_text("utf-8"), "    encoder_step_m: float = parameter("
    file.write_text(text.replace(before, code("parameter") + before, 1), "utf-8")
    script = """
import runpy, sys
from pmwvc_bringup import scenarios
from pmwvc_core.errors import PmwvcError
print(scenarios.to_yaml(scenarios.load("wall", settings_texts=["user1.device.stiction=0.5"])))
try:
    scenarios.load("wall", settings_texts=["device.stiction=-1"])
except PmwvcError as error:
    print(error)
print(runpy.run_path(sys.argv[1])["parameters_page"]())
"""
    page = ROOT / "tools" / "write_reference.py"
    said = run([sys.executable, "-c", script, page], PYTHONPATH=str(tmp_path))
    assert "stiction: 0.5" in said
    assert "device.stiction = -1" in said and "must be >= 0 N" in said
    assert "| `stiction` | 0 | >= 0 N | force that a resting device withstands |" in said


def test_recipe_of_a_coupling(tmp_path, monkeypatch):
    install(tmp_path, "lab_coupling", code("coupling"), entry_points("coupling"))
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()
    assert "backward" in COUPLINGS.names()
    ran = {}
    for coupling, integrator in (
        ("unwrapped", "backward_euler"),
        ("backward", "trapezoid"),
        ("unwrapped", "trapezoid"),
    ):
        texts = [f"server.coupling={coupling}", f"server.integrator={integrator}"]
        scenario = scenarios.load("wall", settings_texts=texts, duration_s=4.0)
        traces = ran[coupling, integrator] = simulate_one(scenario)
        assert inconsistencies(traces, scenario) == []
        assert summary(traces, scenario)["stable"] is True
    forces = [traces.server.f_s[0] for traces in ran.values()]
    np.testing.assert_array_equal(forces[0], forces[1])
    assert np.abs(forces[0] - forces[2]).max() > 1e-3  # the control: the integrator matters


def test_recipe_of_a_figure(tmp_path, monkeypatch):
    made = {}
    exec(compile(code("figure"), "CONTRIBUTING.md", "exec"), made)
    monkeypatch.setattr(figures, "FIGURES", (*figures.FIGURES, made["powers"]))
    traces = handmade.session()
    drawn = figures.charts(traces, handmade.scenario())
    assert drawn[-1].heading == "Power"
    user = traces.users[0]
    expected = user.f_applied[:, 0] * user.xd_m[:, 0] * 1e3
    np.testing.assert_allclose(drawn[-1].panels[0].lines[0].y, expected)
    figures.write_all(drawn[-1:], traces, tmp_path)
    assert {file.name for file in tmp_path.iterdir()} == {"powers.png", "powers.svg"}


@pytest.fixture
def one_more_command(tmp_path, monkeypatch):
    (tmp_path / "ticks.py").write_text(code("command"))
    monkeypatch.setattr(commands, "__path__", [*commands.__path__, str(tmp_path)])
    yield
    sys.modules.pop("pmwvc_bringup.commands.ticks", None)


def test_recipe_of_a_command(one_more_command):
    program = (
        "from pmwvc_bringup import commands; from pmwvc_bringup.cli import main; "
        f"commands.__path__ = {commands.__path__!r}; raise SystemExit(main())"
    )
    words = ["ticks", "wall", "--times", "2", "--duration", "4", "--set", "seed=3", "--json"]
    command = [sys.executable, "-c", program, *words]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    assert json.loads(result.stdout) == {"ticks": 8000}
    assert result.stderr == "8000 ticks\n"
    assert "ticks" in [command.name for command in library()]


@pytest.mark.parametrize(
    ("words", "status", "text"),
    [
        (["ticks", "--help"], 0, "count the ticks of a session."),
        (["--help"], 0, "count the ticks of a session"),
        (["ticks", "wall", "--time", "2"], 2, "unrecognized arguments: --time"),
        (["run", "wall", "--times", "2"], 2, "unrecognized arguments: --times"),
        (["ticks", "wall", "--set", "sed=3"], 2, "did you mean seed?"),
    ],
)
def test_help_and_refusals_know_the_recipes_command(
    one_more_command, tmp_path, words, status, text
):
    result = here(*words, cwd=tmp_path)
    assert result.returncode == status
    assert text in (result.stderr if status else result.stdout)


def test_without_the_file_the_recipes_command_does_not_exist():
    assert "ticks" not in [command.name for command in library()]


def test_one_command_sets_the_version_everywhere(tmp_path):
    for package in PACKAGES:
        (tmp_path / package.name).mkdir()
        for name in ("package.xml", "setup.py"):
            if (package / name).exists():
                shutil.copy(package / name, tmp_path / package.name)
    (command,) = re.findall(r"`\.venv/bin/(catkin_package_version --bump minor)`", TEXT)
    program, *words = command.split()
    old = run([Path(sys.executable).parent / program, ROOT]).strip()
    subprocess.run([Path(sys.executable).parent / program, *words], cwd=tmp_path, check=True)
    files = sorted(tmp_path.glob("*/*"))
    assert len(files) == 2 * len(PACKAGES) - 1  # messages have no setup.py
    assert [file for file in files if old in file.read_text("utf-8")] == []


def test_changelog_has_the_sections_of_a_release():
    text = (ROOT / "CHANGELOG.md").read_text("utf-8")
    first = re.search(r"^## (.*?)\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    assert first[1] == "[Unreleased]"
    assert set(re.findall(r"^### (\w+)", first[2], re.MULTILINE)) <= {"Added", "Changed", "Fixed"}
