# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Device, hands and task as pure functions do what the classes do."""

import math
import random

import numpy as np
import pytest

from pmwvc_core import motion as old_motion
from pmwvc_core.law.plant import motion
from pmwvc_core.law.plant.device import device_step, resting_device, simulated_params
from pmwvc_core.law.plant.forces import RecordedForce, hand_force, hand_hold, recorded_params
from pmwvc_core.law.plant.remote_hand import (
    remote_params,
    resting_remote,
)
from pmwvc_core.law.plant.targets import TableHand, TableParams
from pmwvc_core.params import DeviceParams, OperatorParams, TaskParams
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.forces import ForceOnRecord, Setting
from pmwvc_core.plant.hands import Place, make_hand
from pmwvc_core.plant.operators import make_operator
from pmwvc_core.plant.remote_hand import RemoteHand
from pmwvc_core.plant.targets import GivenTargets

H = 0.001
AXES = pytest.mark.parametrize("axes", [1, 3])


def value(vector):
    return vector[0] if len(vector) == 1 else np.array(vector)


def same(got, wanted, scale=1.0):
    wanted = np.broadcast_to(np.ravel(wanted), np.shape(np.ravel(got)))
    assert np.allclose(np.ravel(got), wanted, rtol=1e-12, atol=1e-12 * scale, equal_nan=True)


def vector(luck, axes, size):
    return tuple(luck.gauss(0.0, size) for _ in range(axes))


@pytest.mark.parametrize("damping", [0.0, 1e-6, 0.3, 5.0, 400.0])
def test_motion(damping):
    for time_s in (0.0, 1e-4, 1e-3, 0.7):
        old, new = old_motion.motion(0.25, damping, time_s), motion.motion(0.25, damping, time_s)
        same(new, [old.xd_x, old.f_x, old.xd_xd, old.f_xd])
    same(
        motion.time_to_rest(0.25, damping, 0.2, -3.0),
        old_motion.time_to_rest(0.25, damping, 0.2, -3.0),
    )


@AXES
@pytest.mark.parametrize("friction", [0.0, 0.6])
@pytest.mark.parametrize("kind", [{}, {"encoder_step_m": 1e-4, "velocity": "euler"}])
def test_device(axes, friction, kind):
    luck = random.Random(axes)
    params = DeviceParams(friction=friction, damping=0.4, workspace_m=0.05, **kind)
    p = simulated_params(params, H)
    s = resting_device((0.01, *(0.0,) * (axes - 1)), p)
    old = SimulatedDevice(params, tick_s=H, dof=axes)
    old.place(0.01)
    stopped = rested = 0
    f_h = f_m = (0.0,) * axes
    for tick in range(6000):
        if tick % 40 == 0:
            f_h, f_m = vector(luck, axes, 1.0), vector(luck, axes, 0.5)
            f_m = f_m if tick % 400 else (0.0,) * axes
            f_h = f_h if tick % 400 else (0.1,) * axes
        s, x, xd = device_step(s, f_h, f_m, p)
        read = old.step(value(f_h), value(f_m))
        stopped += max(map(abs, s.x)) == 0.05
        rested += max(map(abs, s.xd)) == 0.0
        same(x, read[0])
        same(xd, read[1])
        same(s.x, old.x)
        same(s.xd, old.xd)
        same((s.against_j, s.by_hand_j), [np.ravel(each)[0] for each in old.work])
    assert stopped and (rested or not friction)


def both(params, task, axes, side=-1):
    old = make_operator(params, task, Setting(side, 0.05, side * 0.07, H, axes))
    return old, make_hand(params, task, Place(side, 0.05, side * 0.07, H, axes))


def drive(old, s, p, axes, ticks=3000, held=10):
    luck = random.Random(3)
    x, xd = np.full(axes, 0.01), np.zeros(axes)
    for tick in range(ticks):
        at, rate = tuple(x.tolist()), tuple(xd.tolist())
        if tick < held:
            wanted = old.hold()
            s, f_h = hand_hold(s, at, p)
        else:
            wanted = old.step(value(at), value(rate))
            s, f_h = hand_force(s, at, rate, p)
        same(f_h, wanted)
        xd = xd + H / 0.2 * (np.array(f_h) - 2.0 * xd + 0.3 * luck.gauss(0.0, 1.0))
        xd = xd - 0.02 * x
        x = x + H * xd
    return s


@AXES
@pytest.mark.parametrize(
    "fields",
    [
        {"kind": "none"},
        {"kind": "constant", "force": -0.7},
        {"kind": "sinusoid", "frequency_hz": 3.0},
        {"kind": "chirp", "sweep_s": 0.7},
    ],
)
def test_forces(axes, fields):
    old, (s, p) = both(OperatorParams(**fields), TaskParams(), axes)
    drive(old, s, p, axes)


@AXES
@pytest.mark.parametrize("repeat", [True, False])
@pytest.mark.parametrize("kind", ["playback_force", "playback_motion"])
def test_recordings(axes, repeat, kind, tmp_path):
    for columns in {1, axes}:
        rows = 0.02 * np.cumsum(np.random.default_rng(1).normal(size=(700, columns)), axis=0)
        np.save(tmp_path / "rows.npy", rows)
        params = OperatorParams(
            kind=kind, repeat=repeat, file=str(tmp_path / "rows.npy"),
            columns=",".join(map(str, range(columns))),
        )  # fmt: skip
        old, (s, p) = both(params, TaskParams(), axes)
        drive(old, s, p, axes)


@AXES
def test_force_on_record(axes):
    rows = np.random.default_rng(1).normal(size=(700, axes))
    old = ForceOnRecord(rows, tick_s=H, dof=axes)
    drive(old, RecordedForce(0), recorded_params(rows, axes, False, True), axes, held=300)


@AXES
@pytest.mark.parametrize("kind", ["free", "hold", "carry"])
def test_hand(axes, kind):
    task = TaskParams(kind, 0.3, 0.4, 0.9, 0.06, 0.02, 0.3, 0.1)
    old, (s, p) = both(OperatorParams(), task, axes, side=1)
    s = drive(old, s, p, axes)
    same(s.y, old.y)
    same(s.yd, old.yd)
    same(s.effort_j, old.effort_j)


@AXES
def test_remote_hand_with_the_task(axes):
    task = TaskParams("carry", 0.3, 0.4, 0.9, 0.06, 0.02, 0.3, 0.1)
    old, (s, p) = both(OperatorParams(kind="remote"), task, axes, side=1)
    s = drive(old, s, p, axes)
    same(s.hand.arm.y, old.y)
    same(s.hand.effort_j, old.effort_j)
    assert s.hand.grip == 1.0


@AXES
@pytest.mark.parametrize("early", [True, False])
def test_remote_hand_with_a_table(axes, early):
    luck = random.Random(axes)
    params = OperatorParams(kind="remote")
    targets, tick = [], 5
    while tick < 2900:
        tick += luck.choice([0, 3, 16, 16, 30, 30, 200 if luck.random() < 0.2 else 8])
        target = vector(luck, axes, luck.choice([0.03, 0.03, 20.0]))
        targets.append((tick, target if luck.random() < 0.9 else (math.nan,) * axes))
    old = RemoteHand(params, start=0.01, tick_s=H, dof=axes)
    old.source = GivenTargets(
        ((k, None if math.isnan(at[0]) else value(at)) for k, at in targets), early=early
    )
    rows = np.array([at for _, at in targets])
    ticks = np.array([k for k, _ in targets])
    p = TableParams(remote_params(params, H), ticks, rows, tuple(range(axes)), early)
    s = TableHand(resting_remote((0.01, *(0.0,) * (axes - 1))), 0, 0)
    s = drive(old, s, p, axes, held=40)
    same(s.hand.arm.y, old.y)
    same(s.hand.arm.target, old.target)
    same(s.hand.effort_j, old.effort_j)
