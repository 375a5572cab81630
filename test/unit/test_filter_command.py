# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc filter``: documented keys, flags by name, figure, refusals."""

import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from pmwvc_bringup.cli import main
from pmwvc_bringup.commands.answers import filter_

ROOT = Path(__file__).resolve().parents[2]
PRINTED = [
    "--set=master.velocity_filter.order=1",
    "--set=master.velocity_filter.share=0.5",
    "--set=master.velocity_filter.alpha=0.929",
]


def asked(capfd, *words):
    assert main(["filter", "wall_filtered", *words, "--json"]) == 0
    text = capfd.readouterr().out  # inside one process the words stand before the document
    return json.loads(text[text.index("{\n") :])


def test_json_is_one_document_with_the_documented_keys():
    text = filter_.examples
    keys = re.findall(r"\b([a-z]+(?:_[a-z]+)*)\b", text[text.index("Keys of") :])
    done = subprocess.run(
        [ROOT / "pmwvc", "filter", "wall_filtered", "--json"], capture_output=True, check=True
    )
    found = json.loads(done.stdout)
    assert set(found) <= set(keys)
    assert (found["kind"], found["order"], found["alpha"]) == ("exact", 2, None)
    assert found["cutoff_hz"] == pytest.approx(14.54, abs=0.01)
    assert found["designed"] == "lowest cut-off for any environment"
    assert found["flags"] == ["switching"]
    assert found["port_margin"] is None


def test_the_published_filter_is_flagged_by_the_conditions_it_misses(capfd):
    found = asked(capfd, *PRINTED)
    assert found["noise_gain"] == pytest.approx(0.318, abs=5e-4)
    assert found["designed"] == "given"
    assert found["flags"] == ["any_environment", "switching"]
    assert main(["filter", "wall_filtered", *PRINTED]) == 0
    said = capfd.readouterr().out
    assert "  not met: passivity with any environment" in said
    assert "  not met: passivity with a switching environment" in said
    assert "  met: passivity with an environment in phase" in said


def test_only_a_pair_that_keeps_energy_behind_a_passive_rate_drop_is_not_flagged(capfd):
    pair = ("--set=master.velocity_filter.kind=complementary",)
    mean = ("--set=master.filter.kind=integrate_and_dump", "--set=master.filter.pole_rad_s=null")
    assert asked(capfd, *pair)["flags"] == ["switching"]  # of the rate drop
    found = asked(capfd, *pair, *mean)
    assert found["flags"] == []
    assert found["switching_gain"] == 1.0


def test_figure_and_numbers_are_written(tmp_path, capfd):
    found = asked(capfd, "--out", str(tmp_path / "new"))
    written = {path.name for path in (tmp_path / "new").iterdir()}
    assert written == {"filter.png", "filter.svg", "filter.json"}
    assert json.loads((tmp_path / "new" / "filter.json").read_text()) == found
    assert np.isfinite(found["in_phase_margin"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["wall_filtered", "--set=master.velocity_filter.share=0.99"], "no high-pass filter"),
        (["direct_0ms"], "controller = direct: has no velocity filter"),
        (["wall", "--set=master.filter.kind=none"], r"filter.kind = none"),
        (["wall_filtered", "--out", "/dev/null/x"], "cannot write into /dev/null/x: "),
    ],
)
def test_what_has_no_answer_is_reported_with_exit_code_2(words, said, capfd):
    assert main(["filter", *words]) == 2
    assert said in capfd.readouterr().err
