# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the command line answers to a mistake, and how it prints numbers at the edge of reading."""

import os
import stat
import subprocess
from pathlib import Path

import numpy as np
import pytest
from support.plain import load

from pmwvc_analysis.budget.criterion import judge
from pmwvc_analysis.maps.maps import Grid, MapAxis, boundary_words
from pmwvc_analysis.models.answer import sentences
from pmwvc_analysis.verdicts.passivity import amount
from pmwvc_bringup import cli, scenarios
from pmwvc_core.errors import ScenarioError
from pmwvc_core.params.names import hint
from pmwvc_core.runtime.token_files import write_session
from pmwvc_core.words import cell, quantity, share

ROOT = Path(__file__).resolve().parents[2]


def refused(*settings):
    with pytest.raises(ScenarioError) as caught:
        scenarios.load("wall", settings_texts=settings)
    return str(caught.value)


@pytest.mark.parametrize(
    ("setting", "meant"),
    [
        ("b=30", "master.impedance"),
        ("K=300", "server.contact_stiffness"),
        ("user1.b=30", "user1.master.impedance"),
        ("impedance=30", "master.impedance"),
        ("MASTER.IMPEDANCE=30", "master.impedance"),
        ("Link.Delay_s=0.1", "link.delay_s"),
    ],
)
def test_a_symbol_a_last_part_and_capital_letters_find_their_parameter(setting, meant):
    assert f"did you mean {meant}?" in refused(setting)


def test_a_name_that_is_near_to_nothing_is_given_no_hint():
    assert "did you mean" not in refused("xyzxyz=30")


def test_of_equally_near_names_the_first_known_one_is_meant():
    names = ["master.impedance", "server.impedance"]
    assert hint("impedance", names) == "; did you mean master.impedance?"
    assert hint("impedance", names[::-1]) == "; did you mean server.impedance?"


def test_one_name_given_twice_is_a_mistake(capfd):
    words = ["links", "wall", "--set", "link.loss=0.1", "--set"]
    with pytest.raises(SystemExit):
        cli.main([*words, "link.loss=0.2"])
    assert "--set link.loss=0.2: link.loss is given twice" in capfd.readouterr().err
    assert cli.main([*words, "link.up.loss=0.2"]) == 0


def test_a_probability_in_percent_is_told_as_one():
    assert "5 % is 0.05" in refused("link.loss=5")
    assert "%" not in refused("link.loss=-1")


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("link.delay_s=16", "16 ms is 0.016"),
        ("link.jitter_s=5", "5 ms is 0.005"),
        ("link.delay_s=0.5", ""),
    ],
)
def test_a_delay_that_no_network_has_is_told_in_milliseconds(setting, told, capfd):
    assert cli.main(["links", "wall", "--set", setting]) == 0
    said = capfd.readouterr().err
    assert told in said
    assert said.count("\n") == bool(told)


def test_what_a_session_leaves_in_the_tree_and_secrets_are_not_for_git():
    for name in ("keys/server", "keys/user1", "tuned.yaml"):
        found = subprocess.run(["git", "check-ignore", "-q", name], cwd=ROOT, check=False)
        assert found.returncode == 0, name


def test_a_key_is_for_its_owner_whatever_files_are_by_default(tmp_path):
    before = os.umask(0)
    try:
        files = write_session(tmp_path / "keys", ["user1"])
    finally:
        os.umask(before)
    assert {stat.S_IMODE(file.stat().st_mode) for file in files} == {0o600}


def test_a_tuned_scenario_has_the_name_of_its_file(tmp_path, capfd):
    file = tmp_path / "mine.yaml"
    assert cli.main(["tune", "wall", "--set", "channel=plain", "--out", str(file)]) == 0
    tuned = scenarios.load(str(file))
    assert tuned.name == "mine"
    assert tuned.description.startswith("wall as tuned: ")


@pytest.mark.parametrize(
    ("value", "text"), [(-3.84, "-3.84 J"), (-4.2e-17, "0 J"), (-0.384, "-384 mJ")]
)
def test_an_energy_has_the_prefix_that_reads_well_and_rounding_is_zero(value, text):
    assert quantity(value, "J") == text


def test_a_table_shows_neither_rounding_nor_powers_of_ten():
    assert cell(-4.2e-17, 1e3) == "0"
    assert cell(-3.84, 1e3) == "-3840"


@pytest.mark.parametrize(
    ("ratio", "text"), [(1.5286, "1.53 times"), (0.0075, "0.75 % of"), (1.0, "100.00 % of")]
)
def test_more_than_the_whole_is_told_as_a_multiple(ratio, text):
    assert share(ratio) == text


def finding(least_j):
    balance = np.array([0.0, least_j])
    tolerance = np.full(2, 1e-6)
    return judge(
        "user1", "up", np.arange(2.0), balance, tolerance_j=tolerance, moved_j=1e-3, decides=True
    )


def test_a_balance_that_rounding_explains_is_no_amount():
    assert amount(finding(-0.9999e-6)) == "least balance at server steps 0 J, tolerance 1 µJ"
    assert amount(finding(-3e-6)).startswith("least balance at server steps -3 µJ at 1.00 s")


def test_a_growing_mode_is_not_called_the_slowest():
    found = {
        "scenario": "wall", "stable": False, "spectral_radius": 1.02, "k_max": 0.0, "islands": [],
        "k_max_unknown": "",
        "slowest": {"frequency_hz": 62.5, "per_second": 3.0}, "states": 8, "hyperframe_ticks": 8,
        "rigid_body_modes": 0, "notes": [],
    }  # fmt: skip
    text = "\n".join(sentences(found))
    assert "dominant mode: 62.50 Hz, growing" in text
    assert "unstable at every contact stiffness" in text


@pytest.mark.parametrize(
    ("radius", "words"),
    [
        ([[0.9, 0.9], [0.9, 0.9]], "stable everywhere on the map"),
        ([[1.1, 1.1], [1.1, 1.1]], "unstable everywhere on the map"),
        (
            [[0.9, 0.9], [0.9, 1.1]],
            "boundary: at link.delay_s = 0 s stable throughout; at link.delay_s = 0.016 s stable "
            "up to server.contact_stiffness = 1500 N/m",
        ),
        (
            [[0.9, 1.1], [1.1, 1.1]],
            "boundary: at link.delay_s = 0 s stable up to server.contact_stiffness = 1500 N/m; at "
            "link.delay_s = 0.016 s unstable from the first value on",
        ),
    ],
)
def test_a_map_is_told_by_its_boundary(radius, words):
    x, y = (
        MapAxis("server.contact_stiffness", (1000.0, 2000.0)),
        MapAxis("link.delay_s", (0.0, 0.016)),
    )
    assert boundary_words(Grid(load("wall"), x, y), np.array(radius)) == words


def test_every_table_of_a_report_that_scrolls_is_reached_by_keyboard():
    folder = ROOT / "pmwvc_analysis" / "pmwvc_analysis" / "report"
    texts = [file.read_text("utf-8") for file in folder.glob("*_template.html")]
    assert sum(text.count('class="scroll"') for text in texts) > 10
    for text in texts:
        assert text.count('class="scroll"') == text.count('class="scroll" tabindex="0"')
