# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The frequency of the slowest motion is that of the motion, whatever the hyperperiod."""

import numpy as np
import pytest
from support import linear_loops

from pmwvc_analysis.models.answer import answer
from pmwvc_analysis.models.linearize import build


def loop(first, second, period, stiffness=500.0, damping=1.0):
    return linear_loops.scenario(
        user1__master__rate_drop=first,
        user2__master__rate_drop=second,
        server__period_s=period * 1e-3,
        server__contact_stiffness=stiffness,
        server__contact_damping=damping,
    )


def rings_at(scenario):
    """The frequency of what is left of a knock, by its zero crossings."""
    forces = np.zeros((2, 2880))
    forces[:, 0] = 1.0, -0.4
    swing = linear_loops.modelled(build(scenario), forces)["xd"][0, 720:]
    late = swing - swing.mean()
    turns = np.flatnonzero((late[:-1] < 0.0) & (late[1:] >= 0.0))
    return (len(turns) - 1) / ((turns[-1] - turns[0]) * 1e-3)


STIFF = (9, 12, 8, 5000.0, 10.0)


@pytest.mark.parametrize("periods", [(8, 8, 8), (9, 12, 8), STIFF])
def test_the_slowest_motion_has_the_frequency_it_rings_at(periods):
    scenario = loop(*periods)
    found = answer(scenario)["slowest"]["frequency_hz"]
    assert found == pytest.approx(rings_at(scenario), rel=0.05)


def test_frequency_is_not_aliased_by_the_hyperperiod():
    """The control: modulo 1/(72 ms) the answer was another one."""
    found = answer(loop(*STIFF))
    assert found["hyperframe_ticks"] == 72
    assert found["slowest"]["frequency_hz"] > 0.5 / 0.072
