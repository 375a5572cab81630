# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenarios with other numbers by dotted name."""

import math

import pytest
from support import linear_loops

from pmwvc_analysis.models.links import LinkWay, Times
from pmwvc_analysis.models.variation import settled_pace, stackable, with_stiffness
from pmwvc_core.errors import ScenarioError
from pmwvc_core.law.channel.pace import NEW, pace_arrive, pace_step
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


@pytest.mark.parametrize(
    "way",
    [
        LinkWay(Times(7, 0), Times(11, 0), 2),
        LinkWay(Times(8, 0), Times(8, 0), 3),
        LinkWay(Times(11, 2), Times(1, 0), 5),
        LinkWay(Times(4, 0), Times(8, 3), 1),
    ],
)
def test_a_clock_that_has_settled_repeats_with_the_hyperperiod(way):
    def after_another(pace):
        for look in range(way.looked.phase, math.lcm(way.sent[0], way.looked[0]), way.looked[0]):
            for _ in way.arrivals(look):
                pace = pace_arrive(pace, way.sent.period * 1e-3)
            pace, _, _ = pace_step(pace, way.looked.period * 1e-3)
        return pace

    settled = settled_pace(way, 1e-3)
    assert after_another(settled) == pytest.approx(settled, abs=1e-15)
    assert settled.burst_s == 0.0
    assert after_another(NEW) != pytest.approx(NEW, abs=1e-9)  # the control
