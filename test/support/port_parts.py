# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Masters with a filter in their waves, a velocity filter or a bank: moved by hand, and the filter
alone between any waves.
"""

import itertools

import numpy as np

from pmwvc_core.controllers.library import accounts_of_user
from pmwvc_core.ends.inbox import value, vector
from pmwvc_core.law.family import Nothing, accounts
from pmwvc_core.law.port.port_filters import part_in, part_up
from pmwvc_core.law.vectors import plus
from pmwvc_core.law.wave.wave import along
from pmwvc_core.params import BankParams, FilterParams, LocalModelParams, MasterParams
from support.filter_runs import Stage
from support.port_rig import Port

TICK_S = 0.001


class Part:
    """The only filter in the waves of a master, with its state."""

    def __init__(self, master, *, axes=1):
        port, self.axes = Port(master, axes=axes), axes
        place = "far" if isinstance(port.s.filters.near, Nothing) else "near"
        self.s, self.p = getattr(port.s.filters, place), getattr(port.p.port.filters, place)
        self._impedance = port.p.port.impedance
        self._names = [entry.name for entry in accounts_of_user("pmwvc", "plain", master)]

    def down(self, v):
        """Return what it lets through of the returning wave."""
        self._v = vector(v, self.axes)
        return value(self._taken(0.0)[1])

    def offer(self, x=0.0):
        """Return its answer v0 + g u to the wave u of the tick, with the device at x."""
        self.s, _, v0, gains = self._taken(x)
        return lambda u: value(plus(v0, along(self._impedance, gains, vector(u, self.axes))))

    def _taken(self, x):
        return part_in(self.s, self._v, vector(x, self.axes), self.p, self._impedance)

    def step(self, u):
        """Take the outgoing wave; return what of it goes on."""
        self.s, on = part_up(self.s, vector(u, self.axes), self.p, self._impedance)
        return value(on)

    @property
    def energies(self):
        """Energies since the start [J] by name."""
        return dict(zip(self._names, accounts(self.s, self.p), strict=True))


def master(kind="complementary", *, impedance=25.0, matrix="", rate_drop=4, **local):
    return MasterParams(
        impedance=impedance,
        impedance_matrix=matrix,
        rate_drop=rate_drop,
        filter=FilterParams(kind="integrate_and_dump"),
        bank=BankParams(kind=kind),
        local_model=LocalModelParams(**local),
    )


def driven(port, motions, *, wave=0.0):
    """Force of a port moved by hand, every frame of 4 ticks hearing the same wave."""
    forces = []
    x = 0.0 * motions[0]
    for k, xd in enumerate(motions):
        if k % 4 == 0:
            port.receive(wave + 0.0 * xd)
        f = port.step(x, xd)
        port.applied(f)
        x = x + TICK_S * xd
        forces.append(f)
    return np.array(forces)


STILL = (0.0,)  # places of the device


class Echo:
    """A delay of ``delay`` >= 1 ticks and reflections that change: passive."""

    def __init__(self, delay, reflections):
        self._line, self._reflections = [0.0] * delay, itertools.cycle(reflections)

    def step(self, u):
        self._line = [*self._line[1:], u]
        return next(self._reflections) * self._line[0]


class AllPass:
    """R = size (a + 1/z)/(1 + a/z), size <= 1: a passive environment of any phase."""

    def __init__(self, a, size):
        self._a, self._size, self._state = a, size, 0.0

    def step(self, u):
        y = self._a * u + self._state
        self._state = u - self._a * y
        return self._size * y


class Waves:
    """A part, an anti-aliasing filter and an environment that answers a tick later; any wave may
    go out. ``kept`` is the energy that stayed so far, in (wave)^2.
    """

    def __init__(self, params, environment, filtering=None, axes=1):
        self.part, self.environment = Part(params, axes=axes), environment
        self.filter = Stage(filtering, rate_drop=1) if filtering else None
        self.returned = self.kept = self.out = self.least = 0.0

    def step(self, u, x=0.0):
        """Send a wave with the device at x."""
        v = self.part.down(self.returned + 0.0 * u)
        v = v + self.part.offer(x)(u)
        on = self.part.step(u)
        self.returned = self.environment.step(self.filter.step(on) if self.filter else on)
        self.out += np.dot(u, u)
        self.kept += np.dot(u, u) - np.dot(v, v)
        self.least = min(self.least, self.kept)

    def run(self, waves, places=STILL):
        for u, x in zip(waves, itertools.cycle(places), strict=False):
            self.step(u, x)
        return self
