# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One filter of each kind, a trace through it, and holds."""

import numpy as np

from pmwvc_core.ends.inbox import value, vector
from pmwvc_core.law.wave.filter_and_hold import Hold, filter_sample, filter_step, hold, load
from pmwvc_core.made.waves import made_filter
from pmwvc_core.params import FilterParams
from support.strategies import TICK_S

BUTTERWORTH = FilterParams(kind="butterworth", pass_hz=25.0, stop_hz=50.0)
KINDS = [
    FilterParams(kind="none"),
    FilterParams(kind="first_order", pole_rad_s=100.0),
    BUTTERWORTH,
    FilterParams(kind="integrate_and_dump"),
]


class Stage:
    """A filter with its state; floats, or arrays of several axes."""

    def __init__(self, params, *, rate_drop=8, axes=1):
        self.s, self.p = made_filter(params, axes, TICK_S, rate_drop)
        self.axes = axes

    def step(self, u):
        self.s, y = filter_step(self.s, vector(u, self.axes), self.p)
        return value(y)

    def sample(self):
        self.s, y = filter_sample(self.s, self.p)
        return value(y)


class Held:
    """A hold with its state; a ramp of one tick is a zero-order hold."""

    def __init__(self, kind, *, ticks, axes=1):
        rest = (0.0,) * axes
        self.ticks, self.axes = ticks if kind == "foh" else 1, axes
        self.s = Hold(rest, rest, rest, 0)

    def load(self, v):
        self.s = load(self.s, vector(v, self.axes))

    def step(self):
        self.s, v = hold(self.s, self.ticks)
        return value(v)


def run(params, u, *, rate_drop=8):
    """Return the filtered ticks and the packets of a trace."""
    stage = Stage(params, rate_drop=rate_drop, axes=np.size(u[0]))
    ticks, packets = [], []
    for k, wave in enumerate(u):
        if k % rate_drop == 0:
            packets.append(stage.sample())
        ticks.append(stage.step(wave))
    return ticks, packets
