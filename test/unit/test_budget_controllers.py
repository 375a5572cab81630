# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget closes with every controller, and names the part of it that was active."""

import numpy as np
import pytest
from support import plain as files
from support.verdicts import active

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.budget.result import SERVER
from pmwvc_core.simulation.session import simulate_one

WALL = ("server.environment=wall", "operator.kind=sinusoid", "operator.frequency_hz=1.5")
UNKNOWN = ("server.coupling=unknown", "server.contact=bilateral", *WALL)


def simulated(name, *settings, duration_s=4.0):
    scenario = files.load(name, settings_texts=settings, duration_s=duration_s)
    return simulate_one(scenario), scenario


def said(found):
    return [(entry.owner, entry.part) for entry in active(found)]


def test_a_passivity_controller_is_judged_with_the_link_it_pays_for():
    traces, scenario = simulated("carry_16ms", "controller=tdpa", "baseline.tdpa.damping=0")
    found = budget(traces, scenario)
    together = {(owner, part): series for owner, part, series in found.judged()}
    sums = together["user1", "link_and_tdpa_dissipated"]
    alone = found.parts["user1"]["link"]
    np.testing.assert_allclose(sums - alone, found.parts["user1"]["tdpa_dissipated"], atol=1e-12)
    assert sums[-1] > alone[-1]  # it paid


def test_the_published_compensation_is_named():
    settings = (*UNKNOWN, "server.contact_damping=0", "server.contact_stiffness=500")
    printed = budget(*simulated("wall", *settings, "server.compensation=printed"))
    assert (SERVER, "withheld") in said(printed)
    ledger = budget(*simulated("wall", *settings, "server.compensation=ledger"))
    assert not [part for owner, part in said(ledger) if owner == SERVER]


def test_an_environment_with_a_drive_of_its_own_is_named():
    settings = (*UNKNOWN, "operator.force=0.2", "server.environment=active_wall")
    driven = budget(*simulated("wall", *settings))
    assert (SERVER, "environment_stored_and_environment_heat") in said(driven)


def test_a_velocity_filter_is_judged_with_the_filter_that_pays_for_it():
    traces, scenario = simulated("carry_16ms", "master.velocity_filter.kind=exact")
    found = budget(traces, scenario)
    part = "velocity_filter_and_filter_and_hold_and_rate_drop"
    sums = {(o, p): series for o, p, series in found.judged()}["user1", part]
    assert sums.min() > -1e-9
    kept = traces.users[0].accounts["velocity_filter"]
    assert kept.min() < 0.0  # by itself it gives out
    assert not [part for owner, part in said(found) if "velocity_filter" in part]


@pytest.mark.parametrize("feedback", ["budgeted", "integral"])
def test_a_feedback_with_an_energy_tank_is_judged_with_what_pays(feedback):
    settings = ("master.position.gain=40", f"master.position.feedback={feedback}")
    traces, scenario = simulated("carry_16ms", *settings)
    assert all(entry.passive for entry in user_energies(traces))
    assert not [part for owner, part in said(budget(traces, scenario)) if "position" in part]


def test_the_published_feedback_is_named_where_it_gives_out_energy():
    settings = ("master.position.gain=40", "master.position.feedback=printed")
    traces, scenario = simulated("carry_16ms", *settings)
    assert ("user1", "position_spent") in said(budget(traces, scenario))
