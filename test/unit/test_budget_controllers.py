# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget closes with every controller, and names the part of it that was active."""

import pytest
from support import plain as files

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.result import SERVER
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_core.simulation.session import simulate_one

WALL = ("server.environment=wall", "operator.kind=sinusoid", "operator.frequency_hz=1.5")
UNKNOWN = ("server.coupling=unknown", "server.contact=bilateral", *WALL)


def simulated(name, *settings, duration_s=4.0):
    scenario = files.load(name, settings_texts=settings, duration_s=duration_s)
    return simulate_one(scenario), scenario


def said(found):
    return [(entry.owner, entry.part) for entry in found.released]


def judged(name, *settings):
    traces, scenario = simulated(name, *settings)
    return passivity(traces, scenario, budget(traces, scenario))


def test_the_published_compensation_is_named():
    settings = (*UNKNOWN, "server.contact_damping=0", "server.contact_stiffness=500")
    printed = budget(*simulated("wall", *settings, "server.compensation=printed"))
    assert (SERVER, "withheld") in said(printed)
    ledger = judged("wall", *settings, "server.compensation=ledger")
    assert ledger.passive(SERVER) is True
    assert not [each for each in ledger.components if each.owner == SERVER]


def test_an_environment_with_a_drive_of_its_own_is_named():
    settings = (*UNKNOWN, "operator.force=0.2", "server.environment=active_wall")
    driven = budget(*simulated("wall", *settings))
    assert (SERVER, "environment_heat") in said(driven)


@pytest.mark.parametrize("feedback", ["budgeted", "integral"])
def test_a_feedback_with_an_energy_tank_leaves_every_port_passive(feedback):
    settings = ("master.position.gain=40", f"master.position.feedback={feedback}")
    assert judged("carry_16ms", *settings).session is True


def test_the_published_feedback_is_named_where_it_gives_out_energy():
    settings = ("master.position.gain=40", "master.position.feedback=printed")
    traces, scenario = simulated("carry_16ms", *settings)
    assert ("user1", "position_spent") in said(budget(traces, scenario))
