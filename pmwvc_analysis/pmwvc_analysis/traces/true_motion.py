# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The true motion of a device behind its encoder: its model under the recorded forces.

The model of the device goes from rest through the forces of hand and controller as they were
recorded. What comes out is the true motion only if it never leaves the step of the encoder around
the recorded positions: then it is used, else nothing is known but what was measured.

Equations: docs/theory.md 13.8.
"""

from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.params import DeviceParams
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.traces import UserTraces

ROUNDING_M = 1e-9


class TrueMotion(NamedTuple):
    """Position [m] and velocity [m/s] at the start of every tick, and at the end of the last."""

    x: Array  # (tick + 1, dof)
    xd: Array


def measured(params: DeviceParams) -> bool:
    """Tell whether the sensors show something else than the device does."""
    return bool(params.encoder_step_m > 0.0) or params.velocity != "exact"


def complete(user: UserTraces) -> bool:
    """Tell whether the record holds every tick of the master from its first on."""
    return bool(user.tick[0] == 0 and (np.diff(user.tick) == 1).all())


def true_motion(user: UserTraces, params: DeviceParams) -> TrueMotion | None:
    """Return the motion of a device whose sensors show another; None where it cannot be told."""
    if not complete(user) or not np.isfinite(user.f_h).all():
        return None
    dof = user.x_m.shape[-1]
    plant = SimulatedDevice(params, tick_s=user.tick_s, dof=dof)
    plain = dof == 1
    plant.x = float(user.x_m[0, 0]) if plain else user.x_m[0].copy()
    plant.xd = 0.0 * plant.x
    hand = user.f_h[:, 0].tolist() if plain else list(user.f_h)
    force = user.f_applied[:, 0].tolist() if plain else list(user.f_applied)
    x, xd = [plant.x], [plant.xd]
    for f_h, f in zip(hand, force, strict=True):
        plant.step(f_h, f)
        x.append(plant.x)
        xd.append(plant.xd)
    found = TrueMotion(np.reshape(x, (-1, dof)), np.reshape(xd, (-1, dof)))
    off = found.x[:-1] - user.x_m
    if (np.ptp(off, axis=0) > float(params.encoder_step_m) + ROUNDING_M).any():
        return None
    return found
