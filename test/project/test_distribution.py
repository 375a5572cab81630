# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Wheel, container, workflow and citation state what the packages and the README state."""

import re
import shlex
import sys
import tomllib
from pathlib import Path

import yaml
from project.test_imports import imports_of

from pmwvc_bringup.cli import build_parser

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text("utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
WHEEL = ("pmwvc_core", "pmwvc_analysis", "pmwvc_view", "pmwvc_bringup")
OPTIONAL = {"numba", "mujoco"}  # one module needs it, which nothing imports without wanting it
MODULES = {"pyyaml": "yaml"}  # where names differ
ROS = {
    "rclpy", "std_msgs", "std_srvs", "rcl_interfaces", "diagnostic_msgs", "builtin_interfaces",
    "geometry_msgs",
}  # fmt: skip


def declared(requirements):
    names = {re.match(r"[\w-]+", requirement)[0] for requirement in requirements}
    return {MODULES.get(name, name) for name in names}


def test_the_wheel_declares_what_its_packages_import():
    files = [file for name in WHEEL for file in (ROOT / name / name).rglob("*.py")]
    text = "\n".join(file.read_text("utf-8") for file in files)
    names = {name.split(".")[0] for file in files for name in imports_of(file)}
    used = {name for name in names if not name.startswith("pmwvc")} - sys.stdlib_module_names
    assert declared(PROJECT["project"]["dependencies"]) == used - ROS - OPTIONAL
    by_name = set(re.findall(r'import_module\("(\w+)"\)', text))
    extras = PROJECT["project"]["optional-dependencies"].values()
    assert declared(name for names in extras for name in names) <= by_name | OPTIONAL


def test_the_wheel_holds_the_packages_and_their_data():
    wheel = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert wheel["packages"] == [f"{name}/{name}" for name in WHEEL]
    for source in (*wheel["shared-data"], *wheel["force-include"]):
        assert (ROOT / source).exists()
    pattern = PROJECT["tool"]["hatch"]["version"]["pattern"]
    assert re.search(pattern, (ROOT / PROJECT["tool"]["hatch"]["version"]["path"]).read_text())


def test_the_container_is_the_bare_machine_of_the_readme():
    text = (ROOT / "Dockerfile").read_text("utf-8").replace("\\\n", " ")
    (packages,) = re.findall(r"sudo apt install (.*)", README)
    assert f"apt-get install -y {packages}" in re.sub(" +", " ", text)
    assert re.search(r"^FROM debian:12$", text, re.MULTILINE) and "bare Debian 12" in README
    assert 'CMD ["make", "run"]' in text and "\nmake run " in README
    (command,) = re.findall(r"`(docker build .*?)`", README)
    assert command in text
    assert {".venv", ".ros", "sessions"} <= set((ROOT / ".dockerignore").read_text().split())


def test_the_workflow_runs_commands_that_exist():
    text = (ROOT / ".github" / "workflows" / "ci.yml").read_text("utf-8")
    jobs = yaml.safe_load(text)["jobs"]
    targets = re.findall(r"make (\w+)$", text, re.MULTILINE)
    assert targets == ["lint", "test"]
    makefile = (ROOT / "Makefile").read_text("utf-8")
    assert all(re.search(rf"^{target}: setup ", makefile, re.MULTILINE) for target in targets)
    systems = jobs["wheel"]["strategy"]["matrix"]["os"]
    assert [name.partition("-")[0] for name in systems] == ["ubuntu", "macos", "windows"]
    commands = re.findall(r"^ +pmwvc (.+)$", text, re.MULTILINE)
    assert len(commands) > 5
    for words in map(shlex.split, commands):
        assert build_parser().parse_args(words)


def test_hooks_and_citation_have_what_is_asked_for():
    (local,) = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))["repos"]
    entries = [hook["entry"].split()[2:4] for hook in local["hooks"]]
    assert entries == [["ruff", "check"], ["ruff", "format"], ["mypy"]]
    content = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= set(content)
    assert content["license"] == PROJECT["project"]["license"] == "Apache-2.0"
    (thesis,) = content["references"]
    assert thesis["title"] in (ROOT / "docs" / "notation.md").read_text("utf-8")
