# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line on links: what their effects do, also those of another package."""

import json

import pytest
from support.command_line import here
from support.lab import example_of

BURSTS = ("--set", "link.effects=bursts:rate=0.01:stay=0.5")


@pytest.fixture(scope="module")
def pmwvc(tmp_path_factory):
    """The command line beside an installed package: the example of the documentation."""
    with example_of(tmp_path_factory.mktemp("lab"), "links.md") as run:
        yield run


def test_an_effect_of_another_package_is_simulated_judged_and_reported(pmwvc, tmp_path):
    out = tmp_path / "one"
    words = ("carry_16ms", *BURSTS, "--users", "1", "--duration", "1")
    result = pmwvc("simulate", *words, "--out", out)
    assert result.returncode == 0, result.stderr
    assert "Not modelled: bursts of loss of 1.96 % (user1 up" in result.stdout
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    assert any("bursts of loss" in effect for effect in summary["prediction"]["left_out"])
    assert "bursts of loss" in (out / "report.html").read_text("utf-8")  # drawn at the link


def test_links_are_shown_with_their_effects_and_mean_delay(tmp_path):
    words = ["links", "carry_16ms", "--users", "1", "--set", "link.preset=continental"]
    answer = here(*words, "--json", cwd=tmp_path)
    (up, down) = json.loads(answer.stdout)["links"]
    assert up["name"] == "user1/up" and up["mean_delay_s"] == pytest.approx(0.022)
    assert up["does"][0] == "22 ms on the mean" and down["does"] == up["does"]
    assert any("bursts of loss" in effect for effect in up["does"])
    assert f"user1/up: {', '.join(up['does'])}" in answer.stderr
