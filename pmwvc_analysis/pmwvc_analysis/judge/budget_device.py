# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where energy goes between hand and controller: the device with its sampled and held force [J].

======================  ==========================================================================
hand                    sum f_h . (x(k+1) - x(k)): a force held over a tick works on what it moves
device in motion        m |xd|^2 / 2
device damping          b_hd times the integral of |xd|^2, exact between ticks; Coulomb friction;
                        what is lost at a mechanical stop
sample and hold         F . (x(k+1) - x(k)) less F . xd T_c: the controller books the velocity at
                        the tick, the device moves on with the force held
======================  ==========================================================================
"""

import numpy as np

from pmwvc_analysis.judge.budget_clock import NODES, WEIGHTS, Clock, Sums, speeds
from pmwvc_core.numeric import Array
from pmwvc_core.params import DeviceParams
from pmwvc_core.simulation.traces import UserTraces


def device_account(clock: Clock, user: UserTraces, params: DeviceParams) -> Sums:
    """Return ``hand``, ``device_kinetic``, ``device_damping``, ``sample_hold``, ``residual`` [J].

    A hand whose force nobody measured is taken to have given what the device shows; then there is
    no residual.
    """
    x, xd, f = user.x_m, user.xd_m, user.f_applied
    moved = np.diff(x, axis=0, append=x[-1:])
    rendered = np.sum(f * moved, axis=-1)
    kinetic = 0.5 * params.mass * np.sum(xd**2, axis=-1)
    known = bool(np.isfinite(user.f_h).all())
    push = (user.f_h if known else 0.0) - f
    damping = _device_heat(params, user, moved, push)
    found = {
        "device_kinetic": kinetic[clock.ticks_before(user)] - kinetic[0],
        "device_damping": clock.at_ticks(user, damping),
        "sample_hold": clock.at_ticks(user, rendered - np.sum(f * xd, axis=-1) * user.tick_s),
    }
    spent = found["device_kinetic"] + found["device_damping"] + clock.at_ticks(user, rendered)
    hand = clock.at_ticks(user, np.sum(user.f_h * moved, axis=-1)) if known else spent
    if measured(params):
        found["sample_hold"] = found["sample_hold"] + (hand - spent)
        spent = hand
    return {"hand": hand, **found, "residual": hand - spent}


def measured(params: DeviceParams) -> bool:
    """Tell whether the sensors show something else than the device does."""
    return bool(params.encoder_step_m > 0.0) or params.velocity != "exact"


def _device_heat(params: DeviceParams, user: UserTraces, moved: Array, push: Array) -> Array:
    """Return the heat of each tick [J]: damper, friction, stops."""
    xd, tick_s = user.xd_m, user.tick_s
    after = np.concatenate([xd[1:], xd[-1:]])
    if np.isfinite(user.f_h).all() and params.friction == 0.0:
        nodes = speeds(params.mass, params.damping, tick_s, xd, push)
    else:  # within a tick the velocity is as good as a straight line
        nodes = [0.5 * ((1.0 - node) * xd + (1.0 + node) * after) for node in NODES]
    square = sum(0.5 * w * np.sum(v**2, axis=-1) for w, v in zip(WEIGHTS, nodes, strict=True))
    heat = params.damping * tick_s * square
    heat = heat + params.friction * np.sum(np.abs(moved), axis=-1)
    end = np.concatenate([user.x_m[1:], user.x_m[-1:]])
    stopped = (np.abs(end) >= params.workspace_m).any(axis=-1)
    lost = np.sum(push * moved, axis=-1) - 0.5 * params.mass * np.sum(after**2 - xd**2, axis=-1)
    return np.asarray(np.where(stopped, lost, heat), dtype=float)
