# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The set-up finds a Python by itself, and installs exactly what is locked."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools"
SOURCES = {".py", ".msg", ".sh", ".cmake", ".cfg", ".toml"}
TOPS = ("pmwvc_*", "test", "tools", "pyproject.toml")


def command(folder: Path, name: str, text: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / name
    file.write_text(f"#!/bin/sh\n{text}\n", "utf-8")
    file.chmod(0o755)
    return file


@pytest.fixture
def find_python(tmp_path: Path):
    """Run a copy of the script that sees no environment, with a PATH of the test's own."""
    script = tmp_path / "project" / "tools" / "find_python.sh"
    script.parent.mkdir(parents=True)
    shutil.copy(TOOLS / "find_python.sh", script)
    basics = tmp_path / "basics"
    basics.mkdir()
    for name in ("sh", "sed", "dirname"):
        (basics / name).symlink_to(shutil.which(name))

    def run(*folders: Path, **extra: str) -> subprocess.CompletedProcess[str]:
        path = os.pathsep.join(str(folder) for folder in [*folders, basics])
        return subprocess.run(
            ["/bin/sh", script],
            env={"PATH": path} | extra,
            capture_output=True,
            text=True,
            timeout=60,
        )

    return run


@pytest.mark.parametrize("fails", ["echo no such version >&2; exit 127", "exit 1"])
def test_commands_that_fail_and_old_pythons_are_passed_over(find_python, tmp_path, fails) -> None:
    broken, good = tmp_path / "shims", tmp_path / "real folder"
    for name in ("python3", "python3.13", "python3.12", "python3.11"):
        command(broken, name, fails)
    expected = command(good, "python3.12", f'exec "{sys.executable}" "$@"')
    assert find_python(broken, good).stdout == f"{expected}\n"


def test_python_that_cannot_build_is_second_best(find_python, tmp_path: Path) -> None:
    bare = command(
        tmp_path / "bare",
        "python3",
        f'case "$2" in *ensurepip*) exit 1;; esac; exec "{sys.executable}" "$@"',
    )
    assert find_python(bare.parent).stdout == f"{bare}\n"
    full = command(tmp_path / "full", "python3.11", f'exec "{sys.executable}" "$@"')
    assert find_python(bare.parent, full.parent).stdout == f"{full}\n"


def test_python_of_the_present_environment_is_kept(find_python, tmp_path: Path) -> None:
    kept = command(tmp_path / "kept", "python", f'exec "{sys.executable}" "$@"')
    other = command(tmp_path / "other", "python3", f'exec "{sys.executable}" "$@"')
    settings = tmp_path / "project" / ".venv" / "pyvenv.cfg"
    settings.parent.mkdir()
    settings.write_text(f"home = x\nexecutable = {kept}\n", "utf-8")
    assert find_python(other.parent).stdout == f"{kept}\n"
    kept.unlink()
    assert find_python(other.parent).stdout == f"{other}\n"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, ("no Python 3.11, 3.12 or 3.13 found", "make setup PYTHON=")),
        ({"PYTHON": "python2.7"}, ("PYTHON=python2.7 is not a running Python",)),
    ],
)
def test_where_no_python_fits_the_remedy_is_named(find_python, given, words) -> None:
    result = find_python(**given)
    assert (result.returncode, result.stdout) == (1, "")
    assert all(text in result.stderr for text in words)


def test_every_requirement_is_locked_with_hashes() -> None:
    text = (TOOLS / "requirements.txt").read_text("utf-8")
    assert "://" not in text  # a lock names no host
    entries = re.findall(r"^([\w.-]+)==\S+(?: ; .*?)? \\\n((?:    --hash=.*\n)*)", text, re.M)
    assert len(entries) == len(re.findall(r"^\w", text, re.M))
    assert all(hashes for _, hashes in entries)
    wanted = re.findall(r"^([\w.-]+)", (TOOLS / "requirements.in").read_text("utf-8"), re.M)
    assert {name.lower() for name in wanted} <= {name for name, _ in entries}


def test_every_source_file_states_its_licence() -> None:
    files = [
        file
        for top in TOPS
        for path in ROOT.glob(top)
        for file in (path.rglob("*") if path.is_dir() else [path])
        if file.suffix in SOURCES or file.name == "CMakeLists.txt"
    ]
    silent = [
        str(file.relative_to(ROOT))
        for file in files
        if ".egg-info" not in str(file)
        and "SPDX-License-Identifier: Apache-2.0" not in file.read_text("utf-8")[:400]
    ]
    assert len(files) > 50
    assert silent == []


def test_a_step_that_lasts_is_named_again_and_one_that_fails_ends_the_set_up() -> None:
    code = """
import steps, subprocess, sys
steps.AGAIN_S = 0.01
python = [sys.executable, "-c"]
steps.run("a step", [*python, "input()"], {})
try:
    steps.run("another", [*python, "raise SystemExit(3)"], {})
except subprocess.CalledProcessError as error:
    print("failed with", error.returncode)
"""
    with subprocess.Popen(
        [sys.executable, "-c", code],
        env=dict(os.environ, PYTHONPATH=str(TOOLS)),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdin and process.stdout
        assert process.stdout.readline() == "setup_ros: a step\n"
        assert process.stdout.readline() == "setup_ros: a step: 0 s so far\n"
        said = process.communicate("go on\n")[0]
    assert said.endswith("failed with 3\n")
    assert "setup_ros: another\n" in said
