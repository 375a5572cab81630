# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenarios with other numbers by dotted name."""

import pytest
from support import linear_loops

from pmwvc_analysis.models.variation import stackable, with_stiffness
from pmwvc_core.errors import ScenarioError
from pmwvc_core.scenario.names import value_of, varied


def test_a_user_in_front_means_that_user_only():
    scenario = varied(linear_loops.scenario(), "user2.device.mass", 0.4)
    assert [user.device.mass for user in scenario.users] == [0.25, 0.4]
    assert value_of(scenario, "user2.device.mass") == 0.4
    assert value_of(scenario, "device.mass") == 0.25


def test_numbers_may_differ_side_by_side_but_times_may_not():
    assert stackable("server.contact_stiffness")
    assert stackable("user1.master.filter.pole_rad_s")
    for name in ("link.delay_s", "master.rate_drop", "server.period_s", "master.hold"):
        assert not stackable(name)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("server.contact_stifness", 1.0, "did you mean server.contact_stiffness"),
        ("device.mass", -1.0, "must be > 0 kg"),
        ("user7.device.mass", 1.0, "there is no user7"),
        ("dof", 2.0, "make two scenarios"),
    ],
)
def test_a_mistake_is_reported(name, value, words):
    with pytest.raises(ScenarioError, match=words):
        varied(linear_loops.scenario(), name, value)


def test_stiffnesses_keep_their_proportion():
    scenario = linear_loops.scenario(
        user1__server__contact_stiffness=100.0, user2__server__contact_stiffness=400.0
    )
    found = with_stiffness(scenario, 1000.0)
    assert [user.contact.contact_stiffness for user in found.users] == [250.0, 1000.0]
