# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The content of packets by the name of the controller."""

import pytest

from pmwvc_core.controllers.ends import make_master, make_server
from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.params import ContactParams, MasterParams, ServerParams
from pmwvc_core.transport.packet import FLAG_DIRECT
from pmwvc_core.wave.limits import DIRECT, largest_wave


@pytest.mark.parametrize("controller", LIBRARY)
def test_the_content_of_a_packet_is_given_by_its_flag(controller):
    flags = make_master(controller, MasterParams()).flags
    assert bool(flags & FLAG_DIRECT) is not LIBRARY[controller].waves
    one = [ContactParams()]
    server = make_server(controller, ServerParams(), one, [25.0], dof=1, sides=[-1])
    assert server.flags == flags


@pytest.mark.parametrize("controller", LIBRARY)
def test_only_waves_are_bounded_by_the_impedance(controller):
    waves = LIBRARY[controller].waves
    bounds = {largest_wave(b, waves=waves) for b in (5.0, 50.0)}
    assert bounds == {DIRECT} or (waves and len(bounds) == 2)
