# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Coupled axes compiled are the same as interpreted: a grip that touches, leaves, and brakes."""

import math

import numpy as np
import pytest

from pmwvc_core.compiled import compiled
from pmwvc_core.law.server.server_port import Came, SharedScene, environment_step, joined
from pmwvc_core.law.vectors import each
from pmwvc_core.made.server import resting_server, server_params
from pmwvc_core.scenario.reader import parse_scenario

STEPS = 120
GIVEN = {
    "name": "coupled",
    "duration_s": 1.0,
    "controller": "pmwvc",
    "users": 2,
    "dof": 3,
    "channel": "strict",
    "user1": {"master": {"impedance_matrix": "30 6 0; 6 20 4; 0 4 25"}},
}


def driver(p, environment, users, found):
    """Push, slide and let go; every user waits for packets for a while."""
    for n in range(STEPS):
        came = each(wave_of, (users,), n)
        environment = environment_step(p, environment, came)
        for k in range(len(users)):
            port = environment.ports[k]
            for i in range(3):
                found[n, k, i] = port.v_s[i]
                found[n, k, 3 + i] = port.x_s[i]
                found[n, k, 6 + i] = port.avatar.f[i]
        found[n, 0, 9] = environment.dissipated_j
    return environment


def wave_of(user, n):
    sign = 1.0 if user == 0 else -1.0
    push = sign * 1.5 * math.sin(0.06 * n)
    wave = (push, 0.4 * math.cos(0.1 * n) * sign, 0.2)
    return Came(wave, (0.0, 0.0, 0.0), 60 + 10 * user < n < 80, 0.0, ())


driver.__module__ = wave_of.__module__ = "pmwvc_core.law.driver"


@pytest.mark.parametrize("coupling", ["implicit", "unwrapped"])
def test_compiled_coupled_axes_are_the_same(coupling):
    scenario = parse_scenario(GIVEN | {"server": {"coupling": coupling, "contact": "grip"}})
    p = server_params(scenario.users, scenario, scenario.server)
    rest = resting_server(scenario.users, scenario, p).environment
    ports = tuple(
        joined(port, (-0.05 + 0.1 * k, 0.0, 0.0), rest.body)[0]
        for k, port in enumerate(rest.ports)
    )
    start = SharedScene(ports, rest.body, rest.dissipated_j, 0)
    one, other = np.zeros((STEPS, 2, 10)), np.zeros((STEPS, 2, 10))
    driver(p.environment, start, (0, 1), one)
    compiled(driver)(p.environment, start, (0, 1), other)
    assert np.abs(one[:, :, 6:9]).max() > 0.5  # there was contact
    np.testing.assert_allclose(other, one, rtol=1e-12, atol=1e-12)
