# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenarios with other numbers by dotted name."""

import math

import pytest
from support import linear_loops

from pmwvc_analysis.models.links import LinkWay, Times
from pmwvc_analysis.models.variation import settled_pace, with_stiffness
from pmwvc_core.law.channel.pace import NEW, pace_arrive, pace_step


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
