# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What is said of a proposal that was simulated."""

from support import plain as scenarios

from pmwvc_analysis.tune import search
from pmwvc_analysis.tune.criteria import Choice, judged, rated
from pmwvc_analysis.tune.search import bounds_of
from pmwvc_analysis.tune.words import sentences


def _as_it_is(scenario):
    master = scenario.users[0].master
    return master.impedance, master.filter, master.hold


def test_what_a_port_gave_out_when_simulated_is_said_and_behind_counts_no_account_is_claimed():
    coarse = ["device.encoder_step_m=3e-5", "device.velocity=euler"]
    texts = ["channel=strict", "master.rate_drop=1", "server.period_s=0.004", *coarse]
    scenario = scenarios.load("wall", settings_texts=texts)
    assert bounds_of(scenario)[1] <= 0.15 * 0.25 / 0.001  # where the bound of counts is known
    row = judged(scenario, rated(scenario, Choice(*_as_it_is(scenario)), live=False))
    found = search.Proposal(row, {}, bounds_of(scenario), [])
    lines = sentences(scenario, found)
    assert any("proposed" in line and "not proved passive" in line for line in lines)  # M h < 4 ms
    plain = scenarios.load("wall", settings_texts=["channel=plain", *coarse])
    row = judged(plain, rated(plain, Choice(*_as_it_is(plain)), live=False))
    assert row.simulated_passivity.startswith("user1: NOT passive: port of the hand")
    said = sentences(plain, search.Proposal(row, {}, bounds_of(plain), []))
    assert any(row.simulated_passivity in line for line in said)
    wall = scenarios.load("wall")
    row = judged(wall, rated(wall, Choice(*_as_it_is(wall)), live=False))
    assert row.simulated == "stable"
