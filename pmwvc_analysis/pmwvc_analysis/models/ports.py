# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user's end in the linear model: what happens between the packets."""

import numpy as np

from pmwvc_analysis.models.blocks import Block, Device, Hold, column
from pmwvc_analysis.models.filters import make_filter
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.scenario import User


class WavePort:
    """Waves: filter, hold and device.

    Parameters
    ----------
    user
        Parameters; numbers may be columns.
    tick_s
        Period of the force loop [s].
    phase
        Tick of the frame at which an answer is taken.
    """

    signals: tuple[str, ...] = ("u",)

    def __init__(self, user: User, *, tick_s: float, phase: int) -> None:
        master = user.master
        self._b = column(master.impedance)
        self._root = np.sqrt(2.0 * self._b)
        self.device = Device(user.device, tick_s=tick_s)
        self.filter = make_filter(master.filter, tick_s=tick_s, rate_drop=master.rate_drop)
        self.hold = Hold(master.hold, ticks=master.rate_drop, phase=phase)
        self.blocks: dict[str, Block] = {
            "": self.device,
            "filter.": self.filter,
            "hold.": self.hold,
        }

    def send(self) -> list[Array]:
        """Return the packet of a frame start."""
        return [self.filter.sample()]

    def step(self, f_h: Array) -> tuple[Array, Array, Array]:
        """Go one tick on; return x, xd and the controller's force at its start."""
        x, xd = self.device.read()
        v = self.hold.step()
        force = self._b * xd - self._root * v
        self.filter.step(self._root * xd - v)
        self.device.step(f_h - force)
        return x, xd, force

    def wave(self, xd: Array) -> Array:
        """Return the wave, the same both ways, of a uniform motion without force."""
        return 0.5 * self._root * xd

    def steady(self, x: Array, xd: Array) -> list[Array]:
        """Return the states in uniform motion."""
        u = self.wave(xd)
        return [*self.device.steady(x, xd), *self.filter.steady(u), *self.hold.steady(u)]


class DirectPort:
    """Direct coupling: motion goes up, force comes back and is held."""

    signals: tuple[str, ...] = ("x", "xd")

    def __init__(self, user: User, *, tick_s: float, phase: int) -> None:
        self.device = Device(user.device, tick_s=tick_s)
        self.hold = Hold("zoh", ticks=user.master.rate_drop, phase=phase)
        self.blocks: dict[str, Block] = {"": self.device, "hold.": self.hold}

    def send(self) -> list[Array]:
        """Return the packet of a frame start."""
        return list(self.device.read())

    def step(self, f_h: Array) -> tuple[Array, Array, Array]:
        """Go one tick on; return x, xd and the controller's force at its start."""
        x, xd = self.device.read()
        force = self.hold.step()
        self.device.step(f_h - force)
        return x, xd, force

    def wave(self, xd: Array) -> Array:
        """Return zero: nothing comes back in a motion without force."""
        return 0.0 * xd

    def steady(self, x: Array, xd: Array) -> list[Array]:
        """Return the states in uniform motion."""
        return [*self.device.steady(x, xd), *self.hold.steady(0.0 * xd)]
