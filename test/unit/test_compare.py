# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc compare`` and ``pmwvc replay`` as a person meets them, in virtual time."""

import csv
import json
import re

import pytest
from support.command_line import here as pmwvc
from support.command_line import refused


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compared")
    over = ["--over", "link.delay_s=0.016", "--over", "controller=virtual_coupling,direct"]
    words = ["wall", "--duration", "2", *over, "--set", "link.loss=0.1", "--out", "all"]
    result = pmwvc("compare", *words, "--no-figures", "--json", cwd=folder)
    assert result.returncode == 0, result.stderr
    return folder / "all", json.loads(result.stdout)


def test_every_combination_is_a_session_on_disk(compared):
    folder, found = compared
    assert len(found["sessions"]) == 2
    for session in found["sessions"]:
        place = folder / session["folder"]
        summary = json.loads((place / "summary.json").read_text("utf-8"))
        assert summary["source"] == "simulated"
        assert summary["parameters"]["controller"] == session["settings"]["controller"]
        assert summary["stable"] is session["stable"]
        assert pmwvc("doctor", place, cwd=folder).returncode == 0


def test_all_sessions_meet_the_same_packet_fates(compared):
    folder, found = compared
    lost = set()
    for session in found["sessions"]:
        summary = json.loads((folder / session["folder"] / "summary.json").read_text("utf-8"))
        lost.add(tuple(link["lost"] for link in summary["links"] if link["name"].endswith("up")))
    assert len(lost) == 1
    assert min(*lost) > 12


def test_the_tables_tell_the_same_in_every_form(compared):
    folder, found = compared
    assert json.loads((folder / "comparison.json").read_text("utf-8")) == found
    with (folder / "comparison.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    for row, session in zip(rows, found["sessions"], strict=True):
        assert row["label"] == session["label"]
        assert float(row["link.delay_s"]) == session["settings"]["link.delay_s"]
        assert float(row["force_peak_n"]) == session["force_peak_n"]


@pytest.fixture(scope="module")
def rival(tmp_path_factory):
    """A session of a comparison that an exact model answers, and its row."""
    folder = tmp_path_factory.mktemp("rival")
    words = ["wall", "--over", "controller=virtual_coupling", "--duration", "1"]
    first = pmwvc("compare", *words, "--out", "all", "--json", cwd=folder)
    assert first.returncode == 0, first.stderr
    (row,) = json.loads(first.stdout)["sessions"]
    return folder / "all" / row["folder"], row


def test_the_report_holds_its_pictures(rival):
    place, row = rival
    folder = place.parents[1]  # it holds all runs
    page = (folder / "comparison.html").read_text("utf-8")
    assert page.count("data:image/png;base64,") == len([*folder.glob("plots/*.svg")]) > 1
    assert row["label"] in page
    assert (folder / "plots" / "compare_forces.svg").is_file()


def test_a_row_says_how_its_parameters_meet_their_rules(rival):
    place, row = rival
    assert re.fullmatch(r"misses rule colgate by [\d.]+ N s/m|meets its rules", row["tuning"])
    summary = json.loads((place / "summary.json").read_text("utf-8"))
    for name, value in row["parameters"].items():
        assert summary["parameters"][name] == value  # what was simulated


def test_a_session_of_a_comparison_can_be_replayed(rival, tmp_path):
    words = ("replay", rival[0], "--out", "again", "--no-figures", "--json")
    result = pmwvc(*words, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    again = json.loads(result.stdout)
    assert again["exact"] is again["reproduced"] is True
    assert not (tmp_path / "again" / "comparison.html").exists()
    assert pmwvc("doctor", "again", cwd=tmp_path).returncode == 0


@pytest.mark.parametrize(
    ("words", "hints"),
    [
        ("compare carry_0ms --over controller=pmwvc,drect", ["drect"]),
        ("compare active_wall --over controller=pmwvc,tdpa", ["needs controller = pmwvc with"]),
        ("replay nowhere", ["nowhere/scenario.yaml: there is no such file"]),
        (
            "replay FIRST --set master.impedence=3 --set dof=9",
            ["did you mean master.impedance?", "dof = 9"],
        ),
        ("replay FIRST --set users=3", ["keeps the recorded 1"]),
    ],
)
def test_a_mistake_is_reported_and_leaves_nothing_behind(compared, words, hints, tmp_path):
    folder, found = compared
    first = str(folder / found["sessions"][0]["folder"])
    message = refused(pmwvc(*words.replace("FIRST", first).split(), cwd=tmp_path))
    assert [hint for hint in hints if hint not in message] == []
    assert list(tmp_path.iterdir()) == []
