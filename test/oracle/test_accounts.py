# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The budget explains every joule, of any controller, coupling, port, filter and encoder.

Its parts are summed from the signals that blocks exchange and from the accounts that they keep; a
signal or an account that is wrong leaves energy unexplained.
"""

import numpy as np
import pytest
from support import plain as files
from support.simulated import simulated

from pmwvc_analysis.budget import blocks
from pmwvc_analysis.budget.budget import budget
from pmwvc_bringup import scenarios
from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.simulation.session import simulate_one

BLACK_BOX = ("server.coupling=unknown", "server.contact=bilateral")
WAVES = [f"server.coupling={name}" for name in ("one_step_delay", "one_frame_late", "unwrapped")]
CORES = [
    *[(f"controller={name}",) for name in LIBRARY],
    *[(setting,) for setting in WAVES],
    *[
        (*BLACK_BOX, f"server.environment={environment}", f"server.compensation={compensation}")
        for environment in ("wall", "cube", "hunt_crossley")
        for compensation in ("none", "printed", "corrected", "ledger")
    ],
]
PORTS = [
    (),
    ("master.velocity_filter.kind=exact", "master.velocity_filter.cutoff_hz=60"),
    ("master.velocity_filter.kind=equivalent", "master.velocity_filter.cutoff_hz=90"),
    ("master.velocity_filter.kind=complementary",),
    ("master.bank.kind=complementary",),
    ("master.bank.kind=dissertation", "master.local_model.damping=4"),
    ("master.position.gain=15",),
    ("master.bank.kind=complementary", "master.position.gain=15"),
    ("master.position.gain=15", "master.position.feedback=printed"),
]
FILTERS = [
    (),
    ("master.filter.kind=butterworth", "master.filter.stop_hz=60"),
    ("master.filter.kind=integrate_and_dump", "master.filter.pole_rad_s=null"),
    ("master.filter.kind=none", "master.filter.pole_rad_s=null", "master.hold=zoh"),
]
OTHERS = [
    "device.damping=2",
    "device.workspace_m=0.05",
    "link.loss=0.1",
    "link.duplicate=0.1",
    "safety.max_force=1.5",
    "safety.max_slew=20",
    "server.period_s=0.004",
]
AT_ONCE = ("task.grip_s=0.05", "task.grip_rise_s=0.3", "task.move_s=0.5", "task.move_rise_s=0.4")
SEEDS = range(20)  # a turn through every dimension, the rest at random


def session(seed):
    random = np.random.default_rng(seed)
    chosen = [setting for of in (CORES, PORTS, FILTERS) for setting in of[seed % len(of)]]
    texts = [*AT_ONCE, *chosen, *random.choice(OTHERS, size=3, replace=False).tolist()]
    name = "carry_16ms" if seed % 2 else "wall"
    scenario = files.load(name, settings_texts=texts, duration_s=1.2)
    return simulate_one(scenario), scenario


def share(found):
    """The largest residual as a ratio to the energy moved."""
    assert found.moved_j > 1e-4
    return float(np.abs(found.residual_j).max()) / found.moved_j


@pytest.mark.parametrize("seed", SEEDS)
def test_the_budget_closes_and_no_false_signal_is_explained(seed):
    traces, scenario = session(seed)
    found = budget(traces, scenario)
    assert share(found) < 1e-11 and found.notes == []
    (user, *_), server = traces.users, traces.server
    for owner, name in ((user, "x_m"), (user, "f_h"), (server, "kinetic")):
        true = getattr(owner, name)
        setattr(owner, name, 1.01 * true)
        seen = share(budget(traces, scenario))
        assert seen > 1e-6 or not np.ptp(true) or scenario.coupling.black_box, name
        setattr(owner, name, true)


def test_a_block_that_accounts_for_too_little_heat_shows(monkeypatch):
    scenario = files.load(
        "carry_16ms", settings_texts=[*AT_ONCE, "device.damping=2"], duration_s=1.2
    )
    traces, right = simulate_one(scenario), blocks.device_account

    def colder(*signals):
        account = right(*signals)
        return account._replace(dissipated=0.999 * account.dissipated)

    monkeypatch.setattr(blocks, "device_account", colder)
    assert share(budget(traces, scenario)) > 1e-6


DAMPER = 10.0
SEEN = [name for name, each in COUPLINGS.library.items() if not each.black_box]
DAMPERS = (
    *("server.contact=bilateral", "server.contact_stiffness=0", "task.grip_s=0.2"),
    f"server.contact_damping={DAMPER}",
)


@pytest.mark.parametrize("name", SEEN)
def test_the_heat_of_a_step_is_that_of_the_dampers(name):
    texts = [*DAMPERS, f"server.coupling={name}"]
    scenario = scenarios.load("carry_16ms", settings_texts=texts, duration_s=1.5)
    server = simulated(scenario).server
    heat = sum((force[:, 0] ** 2 for force in server.f_s), 0.0) * server.period_s / DAMPER
    found = np.diff(server.dissipated, prepend=0.0)
    np.testing.assert_allclose(found, heat, rtol=1e-9, atol=1e-15 * (1.0 + heat.sum()))
    assert heat.sum() > 1e-6
