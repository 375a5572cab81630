# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The budget, a sum of what blocks state beside their laws, is that computed from traces alone."""

import numpy as np
import pytest
from oracle.offline_budget import offline
from support import plain as files

from pmwvc_analysis.budget import blocks
from pmwvc_analysis.budget.budget import budget
from pmwvc_core.controllers.library import LIBRARY
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
ENCODERS = [(), ("device.encoder_step_m=5e-5", "device.velocity=euler")]
OTHERS = [
    "device.damping=2",
    "device.friction=0.1",
    "device.workspace_m=0.05",
    "link.loss=0.1",
    "link.duplicate=0.1",
    "safety.max_force=1.5",
    "safety.max_slew=20",
    "server.period_s=0.004",
]
AT_ONCE = ("task.grip_s=0.05", "task.grip_rise_s=0.3", "task.move_s=0.5", "task.move_rise_s=0.4")
DIMENSIONS = (CORES, PORTS, FILTERS, ENCODERS)


def drawn(seed):
    """Settings of a session: a turn through every dimension, the rest at random."""
    random = np.random.default_rng(seed)
    chosen = [setting for of in DIMENSIONS for setting in of[seed % len(of)]]
    return [*AT_ONCE, *chosen, *random.choice(OTHERS, size=3, replace=False).tolist()]


def session(seed):
    name = "carry_16ms" if seed % 2 else "wall"
    scenario = files.load(name, settings_texts=drawn(seed), duration_s=1.2)
    return simulate_one(scenario), scenario


def differences(traces, scenario):
    """Every sum of the budget less that of the traces, as a ratio to the energy moved."""
    found, own = budget(traces, scenario), offline(traces, scenario)
    assert np.array_equal(found.time_s, own.time_s)
    assert {o: list(p) for o, p in found.parts.items()} == {
        o: list(p) for o, p in own.parts.items()
    }
    assert found.moved_j > 1e-4
    pairs = [(found.hands[name], own.hands[name]) for name in own.hands]
    pairs += [(found.residuals[name], own.residuals[name]) for name in own.residuals]
    pairs += [(found.parts[o][p], own.parts[o][p]) for o in own.parts for p in own.parts[o]]
    for name, frames in own.frames.items():
        pairs += [(found.at_frames[name][p].sums, frames.sums[p]) for p in frames.sums]
    return max(float(np.abs(a - b).max()) for a, b in pairs) / found.moved_j


SEEDS = range(36)


def test_every_controller_coupling_filter_and_encoder_is_drawn():
    for dimension in DIMENSIONS:
        assert len({seed % len(dimension) for seed in SEEDS}) == len(dimension)


@pytest.mark.parametrize("seed", SEEDS)
def test_accounts_of_blocks_sum_up_to_the_budget_of_the_traces(seed):
    traces, scenario = session(seed)
    assert differences(traces, scenario) < 1e-12


MASTER = "x_m xd_m f_h f_m f_applied u_m u_m_lp v_m".split()
SERVER = "x_o xd_o kinetic potential dissipated".split()


@pytest.mark.parametrize("seed", SEEDS)
def test_what_a_falsified_trace_leaves_unexplained_is_the_same(seed):
    """A budget that closed by construction would explain what the traces do not."""
    traces, scenario = session(seed)
    random = np.random.default_rng(seed)
    chosen = [(traces.users[0], name) for name in random.choice(MASTER, size=3, replace=False)]
    chosen += [(traces.server, name) for name in random.choice(SERVER, size=2, replace=False)]
    for owner, name in chosen:
        true = getattr(owner, name)
        setattr(owner, name, 1.01 * true)
        assert differences(traces, scenario) < 1e-12, name
        setattr(owner, name, true)


def test_a_block_that_accounts_for_too_little_heat_shows(monkeypatch):
    scenario = files.load(
        "carry_16ms", settings_texts=[*AT_ONCE, "device.damping=2"], duration_s=1.2
    )
    traces, right = simulate_one(scenario), blocks.device_account
    assert differences(traces, scenario) < 1e-12

    def colder(*signals):
        account = right(*signals)
        return account._replace(dissipated=0.999 * account.dissipated)

    monkeypatch.setattr(blocks, "device_account", colder)
    assert differences(traces, scenario) > 1e-6


@pytest.mark.parametrize("seed", SEEDS)
def test_the_two_agree_where_a_record_has_gaps_and_no_force_of_the_hand(seed):
    traces, scenario = session(seed)
    user = traces.users[0]
    kept = np.ones(len(user.time_s), dtype=bool)
    kept[400:440] = False
    for name, values in vars(user).items():
        if isinstance(values, np.ndarray) and len(values) == len(kept):
            setattr(user, name, values[kept])
    user.f_h = np.full_like(user.f_h, np.nan)
    assert differences(traces, scenario) < 1e-12
