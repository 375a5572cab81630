# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The command that shows the links of a scenario."""

import json

import pytest
from support.command_line import here


def test_links_are_shown_with_their_effects_and_mean_delay(tmp_path):
    words = ["links", "carry_16ms", "--users", "1", "--set", "link.preset=continental"]
    answer = here(*words, "--json", cwd=tmp_path)
    (up, down) = json.loads(answer.stdout)["links"]
    assert up["name"] == "user1/up" and up["mean_delay_s"] == pytest.approx(0.022)
    assert up["does"][0] == "22 ms on the mean" and down["does"] == up["does"]
    assert any("in bursts" in effect for effect in up["does"])
    assert f"user1/up: {', '.join(up['does'])}" in answer.stderr
