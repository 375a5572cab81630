# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The device: the hand's work, kinetic energy, heat of damper, friction and stops."""

from dataclasses import replace

import numpy as np
from oracle.offline_budget.motion import NODES, WEIGHTS, speeds
from oracle.offline_budget.sums import Clock, Sums, anchored

from pmwvc_analysis.traces.hand_work import TrueMotion, complete, hand_work, measured, true_motion
from pmwvc_core.numeric import Array
from pmwvc_core.params import DeviceParams
from pmwvc_core.traces import UserTraces


def device_account(clock: Clock, user: UserTraces, params: DeviceParams) -> Sums:
    """Return ``hand``, ``device_kinetic``, ``device_damping``, ``rendered``, ``residual`` [J].

    A hand whose force nobody measured is taken to have given what the device shows.
    """
    known = bool(np.isfinite(user.f_h).all())
    motion = true_motion(user, params) if measured(params) else _recorded(user)
    if motion is None:
        return _unresolved(clock, user, params, known=known)
    moved = np.diff(motion.x, axis=0)
    f = user.f_applied
    rendered = _summed(clock, user, np.sum(f * moved, axis=-1), "device")
    kinetic = 0.5 * params.mass * np.sum(motion.xd[:-1] ** 2, axis=-1)
    push = (user.f_h if known else 0.0) - f
    found = {
        "device_kinetic": kinetic[clock.ticks_before(user)] - kinetic[0],
        "device_damping": clock.at_ticks(user, _device_heat(params, user, motion, push)),
    }
    spent = found["device_kinetic"] + found["device_damping"] + rendered
    hand = _summed(clock, user, np.sum(user.f_h * moved, axis=-1), "hand") if known else spent
    return {"hand": hand, **found, "rendered": rendered, "residual": hand - spent}


def _recorded(user: UserTraces) -> TrueMotion:
    return TrueMotion(
        np.concatenate([user.x_m, user.x_m[-1:]]), np.concatenate([user.xd_m, user.xd_m[-1:]])
    )


def _summed(clock: Clock, user: UserTraces, per_tick: Array, said: str) -> Array:
    """Return a running sum of ticks; over gaps that of the master holds, which in the last block
    has a tick that no record shows the end of.
    """
    if complete(user) or said not in user.energy:
        return clock.at_ticks(user, per_tick)
    shown = user.block_time_s < user.time_s[-1] + 0.5 * user.tick_s
    before = replace(user, block_time_s=user.block_time_s[shown])
    return clock.of_ticks(user, anchored(before, per_tick, user.energy[said][shown]))


def _unresolved(clock: Clock, user: UserTraces, params: DeviceParams, *, known: bool) -> Sums:
    """Return what is known of a device whose true motion is not."""
    rendered = hand_work(user, params).at(user, clock.time_s)[0]
    kinetic = 0.5 * params.mass * np.sum(user.xd_m**2, axis=-1)
    in_motion = kinetic[clock.ticks_before(user)] - kinetic[0]
    hand = rendered + in_motion
    if known and "hand" in user.energy:
        ends = np.searchsorted(user.block_time_s, clock.time_s + 0.001 * user.tick_s)
        hand = np.concatenate([[0.0], user.energy["hand"]])[ends]
    return {
        "hand": hand,
        "device_kinetic": in_motion,
        "device_damping": hand - rendered - in_motion,
        "rendered": rendered,
        "residual": 0.0 * hand,
    }


def _device_heat(params: DeviceParams, user: UserTraces, motion: TrueMotion, push: Array) -> Array:
    """Return the heat of each tick [J]: damper, friction, stops."""
    xd, after, tick_s = motion.xd[:-1], motion.xd[1:], user.tick_s
    moved = np.diff(motion.x, axis=0)
    if np.isfinite(user.f_h).all() and params.friction == 0.0:
        nodes = speeds(params.mass, params.damping, tick_s, xd, push)
    else:  # within a tick the velocity is as good as a straight line
        nodes = [0.5 * ((1.0 - node) * xd + (1.0 + node) * after) for node in NODES]
    square = sum(0.5 * w * np.sum(v**2, axis=-1) for w, v in zip(WEIGHTS, nodes, strict=True))
    heat = params.damping * tick_s * square
    heat = heat + params.friction * np.linalg.norm(moved, axis=-1)
    stopped = (np.abs(motion.x[1:]) >= params.workspace_m).any(axis=-1)
    lost = np.sum(push * moved, axis=-1) - 0.5 * params.mass * np.sum(after**2 - xd**2, axis=-1)
    return np.asarray(np.where(stopped, lost, heat), dtype=float)
