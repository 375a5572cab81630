# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The work of the hand at the port where it is: the force applied times the distance moved.

F_k is held while the device goes from x_k to x_{k+1}, so the hand gives the sum of
F_k . (x_{k+1} - x_k). The master records that sum at the end of every block: a simulated device's
is that of its true motion; a real one's, with the step q of its encoder, may be off by up to
q/2 [|F_n| + sum |F_k - F_{k-1}|] (theory.md 13.7, 13.8).
"""

from typing import NamedTuple

import numpy as np

from pmwvc_analysis.traces.holes import gaps
from pmwvc_analysis.traces.sums import ran_s, up_to
from pmwvc_core.law.vectors import zero
from pmwvc_core.numeric import Array
from pmwvc_core.params import DeviceParams
from pmwvc_core.plant.device import Device, device_step, simulated_params
from pmwvc_core.traces import UserTraces
from pmwvc_core.unrolled import unrolled

SAME_RELATIVE = 1e-9
SAME_J = 1e-12
ROUNDING_M = 1e-9


class HandWork(NamedTuple):
    """The work of the hand as sums after known rows; ``ran_s`` is when these had run."""

    ran_s: Array
    sums: Array
    resolution: Array  # how far they may be off, as an encoder has steps

    def at(self, user: UserTraces, times: Array) -> tuple[Array, Array]:
        """Return the work of all ticks that ran by then, and how far it may be off [J]."""
        count = np.searchsorted(self.ran_s, times - 0.001 * user.tick_s)
        return up_to(self.sums, count), up_to(self.resolution, count)


def hand_work(user: UserTraces, device: DeviceParams | None) -> HandWork:
    """Return the work of one user's hand: tick by tick where the recorded positions are what the
    master counted, else at the ends of blocks. Without a ``device`` positions are exact.
    """
    ran, resolution = ran_s(user), np.zeros(len(user.time_s))
    if device is not None and device.encoder_step_m > 0.0:
        size = np.sum(np.abs(user.f_applied), axis=-1)
        change = np.sum(np.abs(np.diff(user.f_applied, axis=0, prepend=0.0)), axis=-1)
        resolution = 0.5 * float(device.encoder_step_m) * (size + np.cumsum(change))
    per_tick = np.sum(user.f_applied * np.diff(user.x_m, axis=0, append=user.x_m[-1:]), axis=-1)
    counted = np.concatenate([[0.0], np.cumsum(per_tick)])
    recorded = user.energy.get("device")
    if recorded is None or not len(recorded):
        return HandWork(ran, counted[1:], resolution)
    after = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s)
    there = np.diff(after, prepend=0) > 0
    recorded, after = recorded[there], after[there]
    before = np.concatenate([[0], after[:-1]])
    own, recorded_own = counted[after] - counted[before], np.diff(recorded, prepend=0.0)
    # whether the sums before a block are on record
    follows = np.concatenate([[user.tick[0] == 0], np.diff(user.tick)[before[1:] - 1] > 0])
    follows &= ~np.isin(before - 1, gaps(user))
    whole = follows & np.append(follows[1:], False)  # the next position is there as well
    rounding = SAME_J + 1e-12 * len(per_tick) * np.abs(per_tick).max(initial=0.0)
    if not np.allclose(own[whole], recorded_own[whole], rtol=SAME_RELATIVE, atol=rounding):
        return HandWork(ran[after - 1], recorded, np.zeros(len(recorded)))
    start = recorded - np.where(follows, recorded_own, own)
    block = np.searchsorted(after, np.arange(len(per_tick)), side="right")
    block = np.minimum(block, len(after) - 1)
    sums = start[block] + counted[1:] - counted[before[block]]
    sums[after - 1] = recorded
    return HandWork(ran, sums, resolution)


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
    """Return the motion of a device, also of one whose sensors show another; None where it cannot
    be told. What the last tick led to is not on record.
    """
    if not measured(params):
        x, xd = (np.concatenate([each, each[-1:]]) for each in (user.x_m, user.xd_m))
        return TrueMotion(x, xd)
    if not complete(user) or not np.isfinite(user.f_h).all():
        return None
    first = tuple(user.x_m[0].tolist())
    rest, p = zero(first), simulated_params(params, user.tick_s)
    s, step = Device(first, rest, first, rest, 0.0, 0.0), unrolled(device_step, len(first))
    found_x, found_xd = [s.x], [s.xd]
    for f_h, f in zip(user.f_h.tolist(), user.f_applied.tolist(), strict=True):
        s, _, _ = step(s, f_h, f, p)
        found_x.append(s.x)
        found_xd.append(s.xd)
    found = TrueMotion(np.array(found_x), np.array(found_xd))
    off = found.x[:-1] - user.x_m
    if (np.ptp(off, axis=0) > float(params.encoder_step_m) + ROUNDING_M).any():
        return None
    return found
