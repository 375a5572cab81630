# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Dotted names: what they mean, and that reader, ROS and variation agree on them."""

import pytest
from support.plain import load

from pmwvc_core.params import MasterParams
from pmwvc_core.params.names import assembled, flat_mapping, flattened, leaves, nested, replaced
from pmwvc_core.scenario.names import resolved, value_of, varied
from pmwvc_core.scenario.scenario import PARAMETERS, Scenario, User, prefixed


def test_every_parameter_of_a_group_has_one_home():
    shared, own = (
        [name for prefix, (_, kind) in prefixed(owner).items() for name in leaves(prefix, kind)]
        for owner in (Scenario, User)
    )
    assert sorted(name for name in PARAMETERS if "." in name) == sorted([*shared, *own])
    assert {name for name, each in PARAMETERS.items() if each.of_user} == {"side", *own}


def test_a_group_goes_by_name_and_back_and_one_nested_value_is_replaced_alone():
    group = MasterParams(impedance=31.0, rate_drop=7)
    values = flattened("m", group)
    assert assembled("m", MasterParams, values) == group
    assert list(values) == list(leaves("m", MasterParams))
    assert flat_mapping(nested(values)) == values
    after = flattened("m", replaced(group, "filter.stop_hz", 33.0))
    assert {name for name in after if after[name] != values[name]} == {"m.filter.stop_hz"}


@pytest.mark.parametrize(
    ("name", "user", "complete"),
    [
        ("dof", 0, ["dof"]),
        ("user2.master.filter.kind", 2, ["master.filter.kind"]),
        ("link.loss", 0, ["link.up.loss", "link.down.loss"]),
        ("user1.link.*.loss", 1, ["link.up.loss", "link.down.loss"]),
        ("link.up.loss", 0, ["link.up.loss"]),
    ],
)
def test_a_name_means_users_and_directions(name, user, complete):
    assert resolved(name) == (user, complete)


def test_file_option_and_variation_set_the_same():
    by_option = load(
        "carry_16ms", settings_texts=["user2.link.delay_s=0.02", "server.object_mass=3"]
    )
    by_name = varied(load("carry_16ms"), "user2.link.delay_s", 0.02)
    by_name = varied(by_name, "server.object_mass", 3.0)
    assert by_option == by_name
    assert value_of(by_name, "user2.link.down.delay_s") == 0.02
    assert value_of(by_name, "server.coupling") is None
