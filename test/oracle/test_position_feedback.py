# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback: rendered stiffness (theory section 11) and lost positions.

A wall of 500 N/m pressed with 1 N, App. E: m = 0.1 kg, b_hd = 1.5, B = 1, b = 25 N s/m, K_p = 20.
Without feedback wall and channel are in series, 1/K_felt = 1/K + tau/(2b).
"""

import functools

import numpy as np
import pytest
from support.simulated import simulated

from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.session import simulate_one

K, B, GAIN = 500.0, 25.0, 20.0
APP_E = {
    "master.rate_drop": 20,
    "master.hold": "zoh",
    "master.filter.kind": "butterworth",
    "master.filter.stop_hz": 50.0,
    "server.period_s": 0.02,
    "server.coupling": "unwrapped",
    "server.integrator": "trapezoid",
}
LIVE = {"link.delay_s": 0.016}
SETTINGS = {
    "App. E": APP_E,
    "live defaults, 16 ms": LIVE,
    "integrate and dump, 24 ms": {
        "link.delay_s": 0.024,
        "master.filter.kind": "integrate_and_dump",
        "master.hold": "zoh",
    },
}


def pressed(kind, setting, *, force=1.0, duration_s=5.0, **more):
    base = {"name": "press", "controller": "pmwvc", "channel": "plain", "users": 1}
    touch = {"contact": "bilateral", "contact_stiffness": K, "contact_damping": 1.0}
    parts = {
        "duration_s": duration_s,
        "device": {"mass": 0.1, "damping": 1.5},
        "operator": {"kind": "constant", "force": force},
        "master": {"impedance": B, "position": {"feedback": kind, "gain": GAIN}},
        "server": {"environment": "wall", **touch},
        "task": {"kind": "free"},
    }
    return parse_scenario(base | parts, overrides={**SETTINGS[setting], **more})


def felt(kind, setting, **more):
    user = simulated(pressed(kind, setting, **more)).users[0]
    return float(user.f_applied[-1, 0] / (user.x_m[-1, 0] - user.x_m[0, 0])), user


@pytest.mark.parametrize("setting", SETTINGS)
def test_how_stiff_a_wall_is_rendered_with_each_feedback(setting):
    """The published one: as it is. Budgeted: between the stiffness without feedback and the wall's
    as far as its energy tank, hardly anywhere if none is kept. Integrals take the channel's spring
    for what it is: no drift, no correction, the device stays F tau/(2b) ahead of its avatar.
    """
    without, _ = felt("none", setting)
    assert without < 0.9 * K or "dump" in setting
    assert without == pytest.approx(357.0, rel=2e-3) or setting != "App. E"
    assert felt("printed", setting)[0] == pytest.approx(K, rel=1e-3)
    reached, user = felt("budgeted", setting)
    assert without + 0.2 * (K - without) < reached < K * 1.001
    if reached < 0.999 * K:
        assert user.accounts["position_surplus"][-1] < 1e-8
    empty, _ = felt("budgeted", setting, **{"master.position.most_j": 0.0})
    assert empty < without + 0.2 * (K - without)
    assert felt("integral", setting)[0] == pytest.approx(without, rel=2e-3)


LOSSES = {
    "a quarter lost": {"link.loss": 0.25, "safety.timeout_s": 1.0},
    "silences and soft starts": {"link.loss": 0.08, "safety.timeout_s": 0.03},
}


def swung(kind, losses):
    """A hand that swings 1 N to and fro at 0.5 Hz through a link that loses packets."""
    swing = {"operator.kind": "sinusoid", "operator.frequency_hz": 0.5}
    soft = {"server.contact_stiffness": 50.0, "server.contact_damping": 5.0}
    more = {**swing, **soft, **LOSSES[losses]}
    return pressed(kind, "live defaults, 16 ms", duration_s=14.0, seed=0, **more)


@functools.cache
def offset_m(kind, losses):
    """Return the mean of device less avatar over the last four periods, its size [m]."""
    traces = simulate_one(swung(kind, losses))
    user, server = traces.users[0], traces.server
    late = server.time_s >= traces.duration_s - 8.0
    ticks = np.searchsorted(user.time_s, server.time_s[late] - 0.5 * user.tick_s)
    apart_m = (user.x_m[ticks, 0] - server.x_s[0][late, 0]).mean()
    return abs(float(apart_m - (user.x_m[0, 0] - server.x_s[0][5, 0])))


@pytest.mark.parametrize(("kind", "losses"), [*zip(("budgeted", "integral"), LOSSES, strict=True)])
def test_positions_that_losses_took_away_come_back(kind, losses):
    without = offset_m("none", losses)
    assert without > 1e-4
    assert offset_m(kind, losses) < 0.25 * without
