# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The accounts that blocks keep while they run: each is described once, beside the block."""

import dataclasses

import numpy as np
import pytest
from support import plain as scenarios

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.parts import account_words, accounted, words_of
from pmwvc_core.account import Entry, Role
from pmwvc_core.controllers.library import LIBRARY, RECORDS, entries
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.server.couplings import COMPENSATIONS
from pmwvc_core.simulation.session import simulate_one

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
        assert account_words(entry.name) == entry.words
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
    assert words_of("link_and_lab_heat") == "link in both directions, laboratory"
    assert account_words("lab_heat") == "damping of the laboratory"
    assert (user.name, "link_and_lab_heat") in [(o, part) for o, part, _ in known.judged()]
    assert (user.name, "link") in known.remainders
    signs = {role: accounted_sign(monkeypatch, heat._replace(role=role)) for role in Role}
    assert signs == {Role.TAKEN: 1, Role.GIVEN: -1, Role.WITHIN: 0, Role.LEVEL: 0, Role.SHOWN: 0}


def accounted_sign(monkeypatch, entry):
    record = dataclasses.replace(LIBRARY["direct"], name="lab", accounts=(entry,))
    monkeypatch.setitem(RECORDS.met, "lab", record)
    found = accounted({entry.name: np.ones(1)})
    return int(found[entry.name][0]) if found else 0
