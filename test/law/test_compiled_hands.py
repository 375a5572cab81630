# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Device, hands and task give the same numbers compiled."""

import numpy as np
import pytest

from pmwvc_core.compiled import compiled
from pmwvc_core.params import DeviceParams, OperatorParams, TaskParams
from pmwvc_core.plant.device import device_step, resting_device, simulated_params
from pmwvc_core.plant.forces import RecordedForce, hand_force, recorded_params
from pmwvc_core.plant.hand import Place, RecordedHand, recorded_motion
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.plant.remote_hand import TableHand, TableParams, remote_params, resting_remote

H = 0.001
TICKS = 2000


def pushed(device, dp, hand, hp, f_m):
    x, xd = device.x, device.xd
    for tick in range(TICKS):
        hand, f_h = hand_force(hand, x, xd, tick >= 100, hp)
        device, x, xd = device_step(device, f_h, f_m, dp)
    return device, hand


pushed.__module__ = "pmwvc_core.law.driver"


def leaves(value):
    if isinstance(value, tuple):
        return [leaf for each in value for leaf in leaves(each)]
    return [float(value)]


@pytest.mark.parametrize("axes", [1, 3])
def test_all_hands(axes):
    task = TaskParams("carry", 0.2, 0.4, 0.9, 0.06, 0.02, 0.3, 0.1)
    at = Place(-1, 0.02, -0.03, H, axes)
    plain = simulated_params(DeviceParams(damping=0.4, workspace_m=1.0), H)
    rough = DeviceParams(friction=0.3, workspace_m=0.05, encoder_step_m=1e-5, velocity="euler")
    rows = 0.02 * np.cumsum(np.random.default_rng(1).normal(size=(1500, axes)), axis=0)
    table = TableParams(
        remote_params(OperatorParams(), H),
        30 * np.arange(50),
        rows[::30],
        tuple(range(axes)),
        True,
    )
    hands = [
        make_hand(OperatorParams(kind=kind), task, at)
        for kind in ("constant", "sinusoid", "chirp", "hand", "remote")
    ]
    hands += [
        (RecordedForce(0), recorded_params(rows, axes, True, True)),
        (RecordedHand(0), recorded_motion(OperatorParams(), rows, at.start, H)),
        (TableHand(resting_remote(at.start), 0, 0), table),
    ]
    ends = set()
    for dp in (plain, simulated_params(rough, H)):
        for hand, hp in hands:
            given = (resting_device(at.start, dp), dp, hand, hp, (0.1,) * axes)
            wanted = leaves(pushed(*given))
            assert np.allclose(leaves(compiled(pushed)(*given)), wanted, rtol=1e-12, atol=1e-12)
            ends.add(wanted[0])
    assert len(ends) > 10  # no two hands do the same
