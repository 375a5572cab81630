# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands and the devices that they move: the laws of ``plant`` with their state."""

import math

import numpy as np

from pmwvc_core.ends.inbox import value, vector
from pmwvc_core.law.vectors import zero
from pmwvc_core.params import DeviceParams, OperatorParams, TaskParams
from pmwvc_core.plant.device import device_step, resting_device, simulated_params
from pmwvc_core.plant.forces import hand_force
from pmwvc_core.plant.hand import Place
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.plant.remote_hand import TableHand, TableParams, remote_params, resting_remote

TICK_S = 0.001
HALF = 0.03


class Hand:
    """A hand with its state; ``before(s, x, p)`` changes it before each tick."""

    def __init__(self, made, axes=1, before=None):
        self.s, self.p = made
        self.axes, self._before = axes, before
        self.work_j, self.x, self.f_h = 0.0, None, (0.0,) * axes

    def step(self, x, xd):
        x, xd = vector(x, self.axes), vector(xd, self.axes)
        if self.x is not None:
            self.work_j += np.dot(self.f_h, np.subtract(x, self.x))
        if self._before:
            self.s = self._before(self.s, x, self.p)
        self.x = x
        self.s, self.f_h = hand_force(self.s, x, xd, True, self.p)
        return value(self.f_h)

    def hold(self, x=0.0):
        x = vector(x, self.axes)
        self.s, f_h = hand_force(self.s, x, zero(x), False, self.p)
        return value(f_h)

    remote = property(lambda self: getattr(self.s, "hand", self.s))
    y = property(lambda self: value(self.remote.y))
    yd = property(lambda self: value(self.remote.yd))
    target = property(lambda self: value(self.remote.target))
    effort_j = property(lambda self: self.remote.effort_j)
    holding = property(lambda self: self.remote.holding)

    def last_j(self, x):
        """The work of the tick just done, which the next step books."""
        return np.dot(self.f_h, np.subtract(vector(x, self.axes), self.x))


class Device:
    """A simulated device with its state."""

    def __init__(self, params, *, x=0.0, xd=0.0, dof=1, tick_s=TICK_S):
        self.axes, self.p = dof, simulated_params(params, tick_s)
        start = (x, *(0.0,) * (dof - 1)) if np.ndim(x) == 0 else vector(x, dof)
        self.s = resting_device(start, self.p)._replace(xd=vector(xd, dof))

    def step(self, f_h, f_m):
        f_h, f_m = vector(f_h, self.axes), vector(f_m, self.axes)
        self.s, _, _ = device_step(self.s, f_h, f_m, self.p)

    def read(self):
        return value(self.s.read_x), value(self.s.read_xd)

    x = property(lambda self: value(self.s.x))
    xd = property(lambda self: value(self.s.xd))
    work = property(lambda self: (self.s.against_j, self.s.by_hand_j))


def operator(kind, *, task="free", side=-1, start=None, dof=1, tick_s=TICK_S, **params):
    times = {"grip_s": 0.1, "grip_rise_s": 0.2, "move_s": 0.5, "move_rise_s": 0.5}
    at = Place(side, HALF, side * HALF if start is None else start, tick_s, dof)
    made = make_hand(OperatorParams(kind=kind, **params), TaskParams(kind=task, **times), at)
    return Hand(made, dof)


def driven(params, targets, *, start=0.0, early=False):
    """State and parameters of a remote hand along one axis with (tick, target) in order."""
    ticks = np.array([tick for tick, _ in targets], dtype=np.int64)
    rows = [math.nan if target is None else target for _, target in targets]
    rows = np.reshape(np.array(rows, dtype=float), (-1, 1))
    p = TableParams(remote_params(params, TICK_S), ticks, rows, (0,), early)
    return TableHand(resting_remote((start,)), 0, 0), p


def forces(made, ticks, x=0.0, xd=0.0):
    return np.array([made.step(x, xd) for _ in range(ticks)])


def device(mass, *, x=0.0, dof=1):
    return Device(DeviceParams(mass=mass, workspace_m=1e6), x=x, dof=dof)


def held_j(grip_stiffness, grip_damping, w):
    """Energy that a grip force held over a tick takes out, see plant/hand.py."""
    return 0.25 * TICK_S * (grip_damping + grip_stiffness * TICK_S / 2) * w**2


def pushes_of(seed, ticks=700):
    """Return forces that wander."""
    return np.random.default_rng(seed).normal(0.0, 3.0, ticks).cumsum() * 0.1
