# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The safety limits with the brake as pure functions do what the classes do."""

import math
import random

import numpy as np
import pytest

from pmwvc_core.law.safety.hand_brake import brake_stiffness
from pmwvc_core.law.safety.limits import (
    LimitsInput,
    expect,
    held_j,
    limits,
    limits_params,
    limits_restart,
    rearm,
    resting_limits,
)
from pmwvc_core.master.brake import HandBrake
from pmwvc_core.master.safety.limiter import SafetyLimiter
from pmwvc_core.params import SafetyParams


def value(vector):
    return vector[0] if len(vector) == 1 else np.array(vector)


def same(got, wanted):
    wanted = np.broadcast_to(np.ravel(wanted), np.shape(np.ravel(got)))
    assert np.allclose(np.ravel(got), wanted, rtol=1e-11, atol=1e-12), (got, wanted)


@pytest.mark.parametrize("brakes", [False, True])
@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("seed", range(5))
def test_every_tick_of_both_is_the_same(brakes, axes, seed):
    luck = random.Random(seed)
    safety = SafetyParams(
        max_force=luck.choice([2.0, 5.0]), max_slew=luck.choice([50.0, 2000.0]), timeout_s=0.03,
        release_s=0.2, soft_start_s=luck.choice([0.05, 0.3]), damper_velocity=0.6,
    )  # fmt: skip
    brake = HandBrake(12.5, tick_s=0.001) if brakes else None
    old = SafetyLimiter(safety, tick_s=0.001, packet_s=0.008, workspace_m=0.05, brake=brake)
    stiffness = brake_stiffness(12.5) if brakes else 0.0
    p = limits_params(safety, 0.001, 0.008, 1.01 * 0.05, stiffness)
    s = resting_limits((0.0,) * axes, p)
    x, xd, f = [0.0] * axes, [0.0] * axes, [0.0] * axes
    silence, interrupted, unreceived, sensed, coupled = math.inf, False, False, True, False
    causes = set()
    for tick in range(4000):
        f = [0.98 * v + luck.gauss(0.0, 0.4) for v in f]
        wild = 0.09 if tick % 2000 > 1800 else 0.01
        xd = [0.99 * v - 0.01 * q + luck.gauss(0.0, wild) for v, q in zip(xd, x, strict=True)]
        x = [0.999 * (q + 0.001 * v) for q, v in zip(x, xd, strict=True)]
        if tick == 50:
            coupled, silence = True, 0.0
        if coupled:
            silence = (
                0.0 if luck.random() < 0.1 and tick % 900 < 600 + 30 * seed else silence + 0.001
            )
        if luck.random() < 0.01:
            interrupted = luck.random() < 0.5 or silence > 0.05
            unreceived = luck.random() < 0.1
        if luck.random() < 0.002 or (not sensed and luck.random() < 0.005 * (1 + seed % 3)):
            sensed = not sensed
        asked, at, moving = tuple(f), tuple(x), tuple(xd)
        if luck.random() < 0.002:
            asked = (luck.choice([math.nan, math.inf]), *asked[1:])
        if luck.random() < 0.001:
            at = (math.nan, *at[1:])
        if luck.random() < 0.001:
            moving = (luck.choice([math.nan, 3.0]), *moving[1:])
        if luck.random() < 0.003:
            old.rearm()
            s = rearm(s)
        if luck.random() < 0.001:
            old.restart()
            s = limits_restart(s)
        if luck.random() < 0.001:
            longer = luck.choice([0.01, 0.05])
            old.expect(longer)
            s = expect(s, longer, p)
        wanted = old.step(
            value(asked), value(at), value(moving), silence, coupled, sensed, interrupted,
            unreceived,
        )  # fmt: skip
        s, got = limits(
            s,
            LimitsInput(asked, at, moving, silence, coupled, sensed, interrupted, unreceived),
            p,
        )
        same(got, wanted)
        assert s.cause == int(np.ravel(old._cause())[0]), tick
        causes.add(s.cause)
        assert s.fading.ready == bool(np.all(old.ready))
        assert s.interventions.events == int(np.ravel(old.events)[0])
        if brakes:
            same(held_j(s, p), brake.stored_j)
    print(sorted(causes))
