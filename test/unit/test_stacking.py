# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenarios of equal structure become one batch; others do not."""

import numpy as np
import pytest

from pmwvc_core.params import ContactParams, MasterParams
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.stacking import batches, stack, structure_of

BASE = {"name": "pair", "duration_s": 5, "controller": "pmwvc", "channel": "plain", "users": 2}


def scenario(**overrides):
    return parse_scenario(BASE, overrides={k.replace("__", "."): v for k, v in overrides.items()})


def test_numbers_that_differ_become_one_row_per_run():
    stacked = stack([ContactParams(contact_stiffness=k) for k in (100.0, 200.0)])
    np.testing.assert_array_equal(stacked.contact_stiffness, [[100.0], [200.0]])
    assert stacked.contact_damping == 10.0


def test_nested_groups_are_stacked_as_well():
    first, second = (
        scenario(master__filter__kind="first_order", master__filter__pole_rad_s=pole)
        .users[0]
        .master
        for pole in (50.0, 100.0)
    )
    np.testing.assert_array_equal(stack([first, second]).filter.pole_rad_s, [[50.0], [100.0]])


def test_what_decides_the_code_that_runs_cannot_differ_within_a_batch():
    with pytest.raises(ValueError, match="rate_drop differs"):
        stack([MasterParams(rate_drop=8), MasterParams(rate_drop=4)])


def test_structure_ignores_numbers_but_not_times_names_or_the_network():
    base = structure_of(scenario())
    for same in ({"server__object_mass": 3}, {"user2__master__impedance": 30}, {"seed": 7}):
        assert structure_of(scenario(**same)) == base
    for other in (
        {"link__delay_s": 0.1},
        {"server__coupling": "one_step_delay"},
        {"master__hold": "zoh"},
        {"duration_s": 4},
        {"task__grip_s": 2},
        {"user2__side": -1},
        {"dof": 2},
    ):
        assert structure_of(scenario(**other)) != base


def test_the_seed_counts_only_where_something_is_random():
    first, second = (structure_of(scenario(link__loss=0.1, seed=seed)) for seed in (1, 2))
    assert first != second


def test_batches_keep_every_scenario_once_and_stay_below_the_largest():
    many = [scenario(server__object_mass=1.0 + i % 3, duration_s=1 + i % 2) for i in range(7)]
    groups = batches(many, smallest=1, largest=2)
    assert sorted(i for group in groups for i in group) == list(range(7))
    assert max(map(len, groups)) == 2
    for group in groups:
        assert len({structure_of(many[i]) for i in group}) == 1


def test_few_runs_of_one_axis_are_stepped_one_by_one():
    few = [scenario(server__object_mass=1.0 + i) for i in range(3)]
    assert batches(few, smallest=4, largest=9) == [[0], [1], [2]]
    assert batches(few, smallest=3, largest=9) == [[0, 1, 2]]
    wide = [scenario(dof=3, server__object_mass=1.0 + i) for i in range(3)]
    assert batches(wide, smallest=4, largest=9) == [[0, 1, 2]]
