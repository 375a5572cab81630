# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Receivers in virtual time expect what live ones expect."""

import pytest
from support import plain as scenarios

from pmwvc_bringup.session import plan
from pmwvc_core.simulation.session import SteppedSession
from pmwvc_core.wave.impedance import largest_wave

TIMES = ("user1.safety.timeout_s=0.05", "user2.safety.timeout_s=0.2", "user2.safety.release_s=7")


@pytest.fixture
def scenario():
    settings = (*TIMES, "user2.master.impedance=40", "user1.server.impedance=10")
    return scenarios.load("carry_16ms", settings_texts=settings)


def test_the_server_is_silent_to_all_users_alike_as_live(scenario, tmp_path):
    nodes = {node.kind: node for node in plan.nodes(scenario, folder=tmp_path, paused=False)}
    live = nodes["server"].parameters
    batch = SteppedSession(scenario)
    assert live["safety.timeout_s"] == 0.2
    assert batch.server.p.release_s == live["safety.release_s"] == 7.0
    for user in batch.users:
        assert user.up.receiver.silence_ns == round(live["safety.timeout_s"] * 1e9)
    own = [user.down.receiver.silence_ns for user in batch.users]
    assert own == [round(user.safety.timeout_s * 1e9) for user in scenario.users]


def test_each_port_takes_the_longest_wave_of_its_own_impedance(scenario):
    for simulated, user in zip(SteppedSession(scenario).users, scenario.users, strict=True):
        server, master = user.server_impedance, user.impedance
        assert simulated.up.receiver.max_wave == largest_wave(server, waves=True)
        assert simulated.down.receiver.max_wave == largest_wave(master, waves=True)
