# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line as a person meets it: starts, ends and whole sessions in processes of their
own, words and refusals in this one.
"""

import functools
import json
import re
import subprocess
import sys

import pytest
import yaml
from support.command_line import ROOT, call, here, refused

COMMANDS = ("run", "simulate", "report", "replay", "compare", "node", "scenarios", "doctor")


@pytest.fixture
def pmwvc(tmp_path):
    """The command line in this process."""
    return functools.partial(here, cwd=tmp_path)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_is_listed_and_explains_itself_with_examples(pmwvc, command):
    assert f"\n    {command} " in pmwvc("--help").stdout
    result = pmwvc(command, "--help")
    assert result.returncode == 0
    assert f"examples:\n  pmwvc {command}" in result.stdout


def test_the_parser_is_there_before_what_is_slow_to_load():
    program = (
        "import sys; from pmwvc_bringup.cli import build_parser; build_parser(); "
        "print([name for name in ('numpy', 'rich', 'yaml') if name in sys.modules])"
    )
    words = [sys.executable, "-c", program]
    assert subprocess.run(words, check=True, capture_output=True, text=True).stdout == "[]\n"


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["simulat", "carry_0ms"], "invalid choice: 'simulat'"),
        (["run", "carry_0ms", "--durration", "1"], "unrecognized arguments: --durration"),
        (["run", "lift", "--set", "dof=3", "seed=2"], "seed=2: each NAME=VALUE needs a --set (or"),
        (["simulate", "wall", "--no-figures", "--over", "x=1,2"], "arguments: --over"),
        (["simulate", "cary_0ms"], "did you mean carry_0ms?"),
        (["run", "wall", "--set", "master.impedence=3"], "did you mean master.impedance?"),
        (["node", "mastre"], "master"),
        ([], "--help"),
        (["run"], "--help"),
        (["simulate", "carry_0ms", "--duration", "0"], "duration_s = 0"),
        (["run", "carry_0ms", "--set", "device.plugin=falcom"], "'falcom': not installed"),
        (["report", "nowhere"], "nowhere"),
        (["doctor", "nowhere"], "nowhere"),
    ],
)
def test_a_wrong_word_gets_the_way_out_and_leaves_nothing(pmwvc, tmp_path, words, hint):
    assert hint in refused(pmwvc(*words))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_use_is_refused(pmwvc, tmp_path):
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "notes.txt").write_text("mine")
    assert "is not empty" in refused(pmwvc("simulate", "carry_0ms", "--out", "old"))
    assert "cannot be made" in refused(pmwvc("simulate", "carry_0ms", "--out", "old/notes.txt/x"))


def test_a_printed_scenario_can_be_simulated_and_is_given_in_words(pmwvc, tmp_path):
    (tmp_path / "mine.yaml").write_text(pmwvc("scenarios", "carry_16ms").stdout)
    result = pmwvc("simulate", "mine.yaml", "--duration", "2", "--no-figures")
    assert result.returncode == 0, result.stderr
    assert "carry_16ms: stable" in result.stdout
    (folder,) = tmp_path.glob("sessions/*-carry_16ms*")
    assert str(folder.relative_to(tmp_path)) in result.stdout


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """One simulated session for a program: where it was called, and what was printed."""
    folder = tmp_path_factory.mktemp("simulated")
    result = call(
        "simulate", "carry_16ms", "--duration", "0.5", "--users", "1", "--out", "short", "--json",
        "--no-figures", "--set", "link.delay_s=0.04", "--set", "user1.operator.squeeze=5",
        cwd=folder,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    return folder, result


def test_json_is_the_summary_and_nothing_else(simulated):
    folder, result = simulated
    assert result.stdout == (folder / "short" / "summary.json").read_text("utf-8")
    assert json.loads(result.stdout)["scenario"] == "carry_16ms"
    assert "session folder" in result.stderr


def test_a_report_written_anew_has_the_same_numbers_and_the_figures_left_out(simulated):
    folder, first = simulated
    numbers = {"summary.json", "budget.json"}
    assert numbers < {path.name for path in (folder / "short").iterdir()}
    assert not list(folder.glob("short/*.html")) + list(folder.glob("short/plots"))
    again = here("report", "short", "--json", cwd=folder)
    assert again.returncode == 0, again.stderr
    assert again.stdout == first.stdout
    assert (folder / "short" / "report.html").is_file()


def test_options_reach_the_session(simulated):
    folder, _ = simulated
    assert here("--version", cwd=folder).stdout.split()[0] == "pmwvc"
    kept = yaml.safe_load((folder / "short" / "scenario.yaml").read_text("utf-8"))
    assert (kept["users"], kept["duration_s"], kept["link"]["up"]["delay_s"]) == (1, 0.5, 0.04)
    assert kept["operator"]["squeeze"] == 5.0


@pytest.mark.parametrize(
    ("settings", "code", "words"),
    [
        ((), 0, "check: passed"),
        (("server.coupling=one_step_delay", "server.contact_stiffness=5000"), 1, "not stable, "),
    ],
)
def test_the_check_makes_the_verdict_the_exit_code(pmwvc, settings, code, words):
    options = [word for setting in settings for word in ("--set", setting)]
    session = ("simulate", "wall", "--duration", "2.5", "--no-figures", "--out", "short")
    first = pmwvc(*session, "--check", *options)
    assert first.returncode == code, first.stdout
    assert words in first.stdout
    if code:  # without the option a verdict is no failure
        assert pmwvc(*session[:-1], "other", *options).returncode == 0


def test_the_doctor_looks_at_everything_and_names_remedies(pmwvc, tmp_path):
    result = pmwvc("doctor", "--json")
    findings = json.loads(result.stdout)["findings"]
    checks = {finding["check"] for finding in findings}
    assert {"python", "ros", "clock", "real time", "disk"} <= checks
    statuses = {finding["status"] for finding in findings}
    assert statuses <= {"ok", "warning", "problem"}
    assert result.returncode == ("problem" in statuses)
    wrong = call("doctor", cwd=tmp_path, ROS_DOMAIN_ID="many")
    assert wrong.returncode == 1
    assert re.search(
        r"^problem .* ROS_DOMAIN_ID=many.*\n +-> ROS_DOMAIN_ID must", wrong.stdout, re.M
    )


def test_a_reader_that_goes_away_is_no_error(tmp_path):
    command = f"'{ROOT}/pmwvc' scenarios carry_0ms | head -n 1"
    result = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command], cwd=tmp_path, capture_output=True, text=True
    )
    assert result.stdout == "name: carry_0ms\n"
    assert result.stderr == ""


def test_scenarios_for_a_program(pmwvc):
    found = json.loads(pmwvc("scenarios", "--json").stdout)
    names = [entry["name"] for entry in found["scenarios"]]
    assert "carry_16ms" in names and names == sorted(names)
    assert "lte" in found["networks"]
    whole = json.loads(pmwvc("scenarios", "wall", "--json").stdout)
    assert whole == yaml.safe_load(pmwvc("scenarios", "wall").stdout)


def test_a_proposal_is_written_as_a_scenario_that_runs(pmwvc, tmp_path):
    result = pmwvc("tune", "wall", "--set", "duration_s=2", "--out", "tuned.yaml", "--json")
    best = json.loads(result.stdout)["best"]["settings"]
    written = yaml.safe_load((tmp_path / "tuned.yaml").read_text("utf-8"))
    assert written["master"]["impedance"] == pytest.approx(best["master.impedance"], abs=0.01)
    assert written["name"] == "tuned" and written["description"].startswith("wall as tuned: ")
    run = ("simulate", "tuned.yaml", "--duration", "0.5", "--no-figures", "--out", "it")
    assert pmwvc(*run).returncode == 0
    assert "must be a new file .yaml or .yml" in refused(
        pmwvc("tune", "wall", "--out", "tuned.yaml")
    )
    assert "must be a new file .yaml or .yml" in refused(
        pmwvc("tune", "wall", "--out", "tuned.txt")
    )
