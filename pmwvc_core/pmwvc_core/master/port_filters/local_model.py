# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Local models of interaction at the rate of the force loop, and their wave port (App. E).

The port decodes a wave u2 into velocity, and encodes the force of the model, at every tick::

    F = F0 + G xd,   xd = sqrt(2/b) u2 - F/b,   v2 = u2 - sqrt(2/b) F
    F = (F0 + sqrt(2/b) G u2)/(1 + G/b),   v2 = (b - G)/(b + G) u2 - sqrt(2/b) F0/(1 + G/b)

The loop through F and xd is solved within the tick, so the port takes exactly F xd.

The spring and damper goes by the implicit midpoint rule: F0 = K x, G = K T_c/2 + B, x+ = x + T_c
xd. Then F xd T_c is what the spring gains plus B xd^2 T_c: passive for every K, B >= 0 and every
tick. It is in place ``everywhere``, or while the *device* is on one side of ``begins_m``: its own
position is that of a high-passed motion, which returns to zero. Where it begins its spring is at
rest; where it ends the energy of the spring is dropped. Meanwhile it pulls as well as it pushes,
since its force comes on top of the one of the server. Where it is not, F = 0 and v2 = u2.

Not here: filters (``filter_bank``), and models from elsewhere (``plugin_model``).

Equations: docs/theory.md 8.1, 8.2, 8.3.
"""

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from pmwvc_core.account import Entry, Role
from pmwvc_core.master.port_filters.plugin_model import PluginModel
from pmwvc_core.numeric import Flag, Value, squared, where
from pmwvc_core.params import LocalModelParams, MasterParams
from pmwvc_core.state import Stateful
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance, impedance_of
from pmwvc_core.wave.reflection import reflection

ENTRIES = STORED, DISSIPATED = (
    Entry("local_stored", "spring of the local model", Role.TAKEN),
    Entry("local_dissipated", "damping of the local model", Role.TAKEN),
)


class Model(Protocol):
    """A local model as its port sees it. Order within a tick: ``offer``, ``take``."""

    def configure(self, params: LocalModelParams) -> None:
        """Take other numbers over, without storing more."""

    def offer(self) -> tuple[Value, Value]:
        """Return F0 [N] and G >= 0 [N s/m] of this tick's force F0 + G xd."""

    def take(self, f: Value, xd: Value, there: Flag) -> None:
        """Go on for a tick with the mean force [N] and velocity [m/s], where it is there."""

    def drop(self, gone: Flag) -> None:
        """Let go of what is stored where it is no longer there."""

    @property
    def stored(self) -> Value:
        """Energy held [J]."""

    @property
    def dissipated(self) -> Value:
        """Energy turned into heat or dropped since the start [J]."""


class SpringDamper(Stateful):
    """F = K x + B xd to ground, by the implicit midpoint rule; at rest at first."""

    SIGNALS = "x"
    MEMORY = "dissipated"

    def __init__(self, params: LocalModelParams, *, tick_s: float) -> None:
        self._tick_s = tick_s
        self.x: Value = 0.0
        self.dissipated: Value = 0.0
        self._begin(params)

    def configure(self, params: LocalModelParams) -> None:
        """Take other numbers over; the old spring is dropped."""
        self.drop(True)
        self._begin(params)

    def _begin(self, params: LocalModelParams) -> None:
        self._stiffness, self._damping = params.stiffness, params.damping
        self._slope = params.stiffness * (0.5 * self._tick_s) + params.damping

    def offer(self) -> tuple[Value, Value]:
        """Return K x and K T_c/2 + B."""
        return self._stiffness * self.x, self._slope

    def take(self, f: Value, xd: Value, there: Flag) -> None:
        """Stretch the spring."""
        if there is not True:
            xd = where(there, xd, 0.0 * xd)
        self.x = self.x + self._tick_s * xd
        self.dissipated = self.dissipated + squared(xd) * self._damping * self._tick_s

    def drop(self, gone: Flag) -> None:
        """Let the spring go."""
        self.dissipated = self.dissipated + where(gone, self.stored, 0.0)
        self.x = where(gone, 0.0 * self.x, self.x)

    @property
    def stored(self) -> Value:
        """Energy of the spring, K |x|^2/2 [J]."""
        return squared(self.x) * self._stiffness * 0.5


class LocalPort(Stateful):
    """The wave port of a local model. Order within a tick: ``offer``, ``step``.

    Parameters
    ----------
    params
        Impedance, tick and the model; numbers may be ``(runs, 1)``.
    position
        Returns the device's position [m].
    """

    BLOCKS = "model"
    SIGNALS = "_f0"
    MEMORY = "_slope _there"

    def __init__(self, params: MasterParams, position: Callable[[], Value]) -> None:
        local, b = params.local_model, impedance_of(params)
        self.model: Model = (
            PluginModel(local, matched=_plain(b), tick_s=params.tick_s)
            if local.is_plugin
            else SpringDamper(local, tick_s=params.tick_s)
        )
        self._position = position
        self._begin(params)
        self._f0: Value = 0.0
        self._slope: Value = 0.0

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over. Waves carry the same power whatever the impedance."""
        if params.local_model != self._params:
            self.model.configure(params.local_model)
        self._begin(params)

    def _begin(self, params: MasterParams) -> None:
        self._there: Flag = True
        self._params = params.local_model
        self._reflection = reflection(impedance_of(params))

    def offer(self) -> tuple[Value, Value]:
        """Return v0 [sqrt(W)] and g of the answer v0 + g u2."""
        f0, slope = self.model.offer()
        if self._params.acts != "everywhere":
            there = self._touching()
            self.model.drop(there ^ True)
            f0, slope = where(there, f0, 0.0), where(there, slope, 0.0)
            self._there = there
        self._f0, self._slope = f0, slope
        return self._reflection.of(f0, slope)

    def step(self, u2: Value) -> Value:
        """Take the wave of the tick; return the one that comes back [sqrt(W)]."""
        f, xd, v2 = self._reflection.solve(u2, self._f0, self._slope)
        self.model.take(f, xd, self._there)
        return v2

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energy stored and energy dissipated by the model [J]."""
        return {STORED.name: self.model.stored, DISSIPATED.name: self.model.dissipated}

    def _touching(self) -> Flag:
        x = self._position()
        along = x[..., :1] if isinstance(x, np.ndarray) and x.ndim else x
        begins = self._params.begins_m
        return along > begins if self._params.acts == "above" else along < begins


def _plain(b: Impedance) -> Value:
    """Return a number in the place of an impedance."""
    return float(np.mean(b.values)) if isinstance(b, MatrixImpedance) else b
