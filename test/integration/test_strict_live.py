# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The strict channel between real nodes: energy and motion over an impaired link, as recorded."""

import numpy as np
import pytest
from support.excuses import unless_stalled
from support.verdicts import given_while_still_j

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_core.law.port.strict_master import LIMIT_J

pytestmark = pytest.mark.integration
LEAST_J = -1e-9  # of any balance and of any node: rounding of sums


def test_every_port_is_passive_over_an_impaired_link_and_predicted_to_be(impaired):
    assert impaired.code == 0, impaired.output()
    assert read_scenario(impaired.folder).strict
    summary = impaired.summary()
    assert summary["source"] == "live"
    ports = summary["passivity"]["ports"]
    assert {port["part"] for port in ports} == {"up", "down", "hand_port", "server"}
    held = [port for port in ports if port["held_j"]]  # a machine that stood still, a force on
    hits = {outcome["what"]: outcome["hit"] for outcome in summary["outcomes"]}
    with unless_stalled(lambda: held):
        assert all(port["passive"] for port in ports), summary["passivity"]["text"]
        assert hits["passivity"] is True
    assert hits.get("offset") is None  # the latest packet is not known before


def test_no_link_gives_more_than_was_declared_and_no_node_is_below_its_limit(impaired):
    traces, scenario = read_session(impaired.folder), read_scenario(impaired.folder)
    for user, energy in zip(traces.users, user_energies(traces, scenario), strict=True):
        held_j = given_while_still_j(user)
        for balance in (energy.up, energy.down):
            lent_j = max(scenario.server.store_j, scenario.users[0].master.store_j)
            assert 0.0 < balance.declared_j <= lent_j  # to a playout whose packets are late
            assert balance.minimum_j >= LEAST_J - balance.declared_j
        lent_j = sum(balance.declared_j for balance in (energy.up, energy.down))
        assert energy.joint.minimum_j >= LEAST_J - lent_j - held_j
        # A force is paid for when its tick is over: the motion may change within it.
        assert user.accounts["node"].min() >= LEAST_J - LIMIT_J - held_j
        assert energy.up.energy_in_j[-1] > 1e-4  # something was sent
    assert inconsistencies(traces, scenario) == []


def test_the_link_did_impair_it_and_the_receivers_saw_that(impaired):
    """The control."""
    for link in impaired.summary()["receptions"]:
        assert link["counts"]["lost"] > 5 and link["counts"]["duplicate"] > 5
    traces = read_session(impaired.folder)
    assert min(np.abs(user.f_applied).max() for user in traces.users) > 0.5
