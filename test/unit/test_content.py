# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What packets carry, by the name of the controller."""

import pytest

from pmwvc_core.controllers import MASTERS, SERVERS, make_master
from pmwvc_core.params import MasterParams
from pmwvc_core.simulation.scenario import CONTROLLERS
from pmwvc_core.wave.content import has_waves
from pmwvc_core.wave.limits import DIRECT, largest_wave
from pmwvc_core.wave.packet import FLAG_DIRECT


def test_every_controller_of_a_scenario_has_both_its_ends():
    assert set(MASTERS) == set(SERVERS) == set(CONTROLLERS)


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_what_a_packet_carries_is_said_by_its_flag(controller):
    flags = make_master(controller, MasterParams()).flags
    assert bool(flags & FLAG_DIRECT) is not has_waves(controller)
    assert SERVERS[controller].flags == flags


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_only_waves_are_bounded_by_the_impedance(controller):
    bounds = {largest_wave(controller, b) for b in (5.0, 50.0)}
    assert bounds == {DIRECT} or (has_waves(controller) and len(bounds) == 2)
