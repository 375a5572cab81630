# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy accounts of single blocks, and those that blocks keep while they run: each described
once.
"""

import dataclasses

import numpy as np
import pytest
from support import plain as scenarios
from support.operators import TICK_S, Device

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.parts import words_of
from pmwvc_core.account import Entry, Role
from pmwvc_core.controllers.library import LIBRARY, RECORDS, entries
from pmwvc_core.params import DeviceParams
from pmwvc_core.plant.device import device_account
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.server.couplings import COMPENSATIONS
from pmwvc_core.simulation.session import simulate_one

DEVICE = DeviceParams(mass=0.3, damping=2.0, workspace_m=0.02)


def driven(params, dof):
    """A device under changing forces that meets its stops: motion and forces per tick."""
    random = np.random.default_rng(dof)
    plant = Device(params, dof=dof)
    f_h, f_m = 8.0 * random.standard_normal((2, 400, dof)).cumsum(axis=1) / 20.0
    x, xd = [np.zeros(dof)], [np.zeros(dof)]
    for hand, force in zip(f_h, f_m, strict=True):
        plant.step(hand, force)
        x.append(np.atleast_1d(plant.x).copy())
        xd.append(np.atleast_1d(plant.xd).copy())
    return np.array(x), np.array(xd), f_h, f_m, plant


@pytest.mark.parametrize("dof", [1, 3])
def test_a_device_takes_what_it_gives_stores_and_turns_to_heat(dof):
    x, xd, f_h, f_m, plant = driven(DEVICE, dof)
    ends = (x[:-1], xd[:-1]), (x[1:], xd[1:])
    account = device_account(DEVICE, TICK_S, *ends, f_h, f_m)
    assert (np.abs(x) >= DEVICE.workspace_m).any()  # the stops are met
    np.testing.assert_allclose(account.residual, 0.0, atol=1e-12)
    assert np.sum(account.taken) == pytest.approx(plant.work[1], rel=1e-9)
    assert np.sum(account.given) == pytest.approx(plant.work[0], rel=1e-9)
    assert (account.dissipated > -1e-15).all()
    # the control: a heavier device is not where these forces lead
    other = device_account(dataclasses.replace(DEVICE, mass=0.33), TICK_S, *ends, f_h, f_m)
    assert np.abs(other.residual).max() > 1e-6


UNKNOWN = {"server.coupling": "unknown", "server.environment": "wall"}
VARIANTS = [
    *({"controller": name} for name in LIBRARY),
    *({"master.velocity_filter.kind": k} for k in ("exact", "equivalent", "complementary")),
    *({"master.bank.kind": k} for k in ("dissertation", "complementary")),
    *(
        {"master.position.gain": 5.0, "master.position.feedback": k, "channel": c}
        for k, c in (("printed", "plain"), ("integral", "plain"), ("budgeted", "strict"))
    ),
    {"channel": "strict"},
    {"channel": "zeroing"},
    *(UNKNOWN | {"server.compensation": name} for name in COMPENSATIONS.library),
]


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda v: "-".join(map(str, v.values())))
def test_every_account_of_a_session_is_described(variant):
    base = {"name": "kept", "duration_s": 0.05, "controller": "pmwvc", "channel": "plain"}
    traces = simulate_one(parse_scenario(base | {"users": 1}, overrides=variant))
    kept = {*traces.users[0].accounts, *traces.server.accounts}
    assert kept <= set(entries()), kept - set(entries())
    own = LIBRARY[variant.get("controller", "pmwvc")].accounts
    own += COMPENSATIONS.of(variant.get("server.compensation", "none")).accounts
    assert kept <= {entry.name for entry in own}, "by the record that keeps it"


def test_names_are_unique_and_every_account_has_words():
    records = [*RECORDS.library.values(), *COMPENSATIONS.library.values()]
    names = [entry.name for record in records for entry in record.accounts]
    assert len(names) == len(set(names))
    for entry in entries().values():
        assert words_of(entry.name) == (entry.part or entry.words)


def test_an_account_of_another_package_is_a_part_of_the_budget(monkeypatch):
    """A controller that keeps an account gets its words and its sign by describing it."""
    heat = Entry("lab_heat", "damping of the laboratory", Role.TAKEN, part="laboratory")
    record = dataclasses.replace(LIBRARY["direct"], name="lab", accounts=(heat,))
    scenario = scenarios.load("carry_0ms", settings_texts=["controller=direct"], duration_s=1.0)
    traces = simulate_one(scenario)
    user = traces.users[0]
    user.accounts["lab_heat"] = np.linspace(0.0, 1e-3, len(user.block_time_s))
    unknown = budget(traces, scenario).parts[user.name]
    assert "lab_heat" not in unknown  # the control: an account that no record describes
    monkeypatch.setitem(RECORDS.met, "lab", record)
    known = budget(traces, scenario)
    parts = known.parts[user.name]
    assert parts["lab_heat"][-1] == pytest.approx(1e-3, rel=0.02)
    assert parts["link"][-1] == pytest.approx(unknown["link"][-1] - parts["lab_heat"][-1])
    assert words_of("lab_heat") == "laboratory"
    assert (user.name, "link") in known.remainders
