# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Operators and the devices that they move."""

import numpy as np

from pmwvc_core.params import DeviceParams, OperatorParams, TaskParams
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.forces import Setting
from pmwvc_core.plant.operators import make_operator

TICK_S = 0.001
HALF = 0.03


def operator(kind, *, task="free", side=-1, start=None, dof=1, tick_s=TICK_S, **params):
    times = {"grip_s": 0.1, "grip_rise_s": 0.2, "move_s": 0.5, "move_rise_s": 0.5}
    return make_operator(
        OperatorParams(kind=kind, **params),
        TaskParams(kind=task, **times),
        Setting(side, HALF, side * HALF if start is None else start, tick_s, dof),
    )


def forces(made, ticks, x=0.0, xd=0.0):
    return np.array([made.step(x, xd) for _ in range(ticks)])


def device(mass, *, x=0.0, dof=1):
    made = SimulatedDevice(DeviceParams(mass=mass, workspace_m=1e6), tick_s=TICK_S, dof=dof)
    made.place(x)
    return made
