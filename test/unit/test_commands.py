# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A command is one file: its record is found, listed, parsed and run."""

import json
import subprocess
import sys

import pytest

from pmwvc_bringup import commands
from pmwvc_bringup.cli import main
from pmwvc_bringup.parser import ORDER, library

TICKS = '''
"""``pmwvc ticks``: the force-loop ticks of a session."""

from pmwvc_bringup.command import Command, Result, argument
from pmwvc_bringup.options import SCENARIO, USERS, duration, json_document, scenario_of, settings


def run(arguments):
    scenario = scenario_of(arguments)
    ticks = round(arguments.times * scenario.duration_s / scenario.tick_s)
    print(f"{ticks} ticks")
    return Result(3, {"ticks": ticks})


COMMAND = Command(
    name="ticks",
    help="count the ticks of a session",
    examples="examples:\\n  pmwvc ticks wall\\n",
    arguments=(
        SCENARIO, USERS, settings(), duration(), argument("--times", type=int, default=1),
        json_document(),
    ),
    run=run,
)
'''


@pytest.fixture
def one_more(tmp_path, monkeypatch):
    (tmp_path / "ticks.py").write_text(TICKS)
    monkeypatch.setattr(commands, "__path__", [*commands.__path__, str(tmp_path)])
    yield
    sys.modules.pop("pmwvc_bringup.commands.ticks", None)


def test_without_the_file_there_is_no_such_command():
    assert [command.name for command in library()] == list(ORDER)


def test_a_file_is_a_command(one_more):
    program = (
        "from pmwvc_bringup import commands; from pmwvc_bringup.cli import main; "
        f"commands.__path__ = {commands.__path__!r}; raise SystemExit(main())"
    )
    words = ["ticks", "wall", "--times", "2", "--duration", "4", "--set", "seed=3", "--json"]
    command = [sys.executable, "-c", program, *words]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 3
    assert json.loads(result.stdout) == {"ticks": 8000}
    assert result.stderr == "8000 ticks\n"
    assert [command.name for command in library()] == [*ORDER, "ticks"]


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["ticks", "--help"], 0, "count the ticks of a session."),
        (["--help"], 0, "count the ticks of a session"),
        (["ticks", "wall", "--time", "2"], 2, "did you mean --times?"),
        (["run", "wall", "--times", "2"], 2, "--times is an option of ticks only"),
    ],
)
def test_help_and_refusals_know_it(one_more, capfd, words, code, text):
    with pytest.raises(SystemExit) as caught:
        main(words)
    assert caught.value.code == code
    assert text in "".join(capfd.readouterr())


def test_a_mistake_in_its_scenario_is_told_in_one_message(one_more, capfd):
    assert main(["ticks", "wall", "--set", "sed=3"]) == 2
    captured = capfd.readouterr()
    assert captured.out == ""
    assert "did you mean seed?" in captured.err
