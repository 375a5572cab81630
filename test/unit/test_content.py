# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The content of packets by the name of the controller."""

import pytest

from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame import DeviceSample
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.transport.packet import FLAG_DIRECT
from pmwvc_core.wave.impedance import DIRECT, largest_wave


@pytest.mark.parametrize("controller", LIBRARY)
def test_the_content_of_a_packet_is_given_by_its_flag(controller):
    scenario = parse_scenario(
        {"name": "one", "duration_s": 1.0, "controller": controller, "users": 1}
    )
    user, server = UserEnd(scenario.users[0], scenario, epoch=1), ServerEnd(scenario)
    sent = user.start_frame(0, 0, DeviceSample())
    [answer], _ = server.tick(0, [[sent]])
    for packet in (sent, answer):
        assert bool(packet.flags & FLAG_DIRECT) is not LIBRARY[controller].waves
    other = "direct" if LIBRARY[controller].waves else "pmwvc"  # the control
    ignores = ServerEnd(
        parse_scenario({"name": "one", "duration_s": 1.0, "controller": other, "users": 1})
    )
    assert ignores.tick(0, [[sent]])[0] == [None]
    assert ignores.other_controller == 1


@pytest.mark.parametrize("controller", LIBRARY)
def test_only_waves_are_bounded_by_the_impedance(controller):
    waves = LIBRARY[controller].waves
    bounds = {largest_wave(b, waves=waves) for b in (5.0, 50.0)}
    assert bounds == {DIRECT} or (waves and len(bounds) == 2)
