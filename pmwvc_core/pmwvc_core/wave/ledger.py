# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Running sums of energy at a wave and at a force-velocity port.

Plain sums: a day at 1 kHz adds 1e8 terms, and the rounding of all of them stays below 1e-8 of the
sum, far less than what a sensor can tell. No budget is kept here: these only count.
"""

from pmwvc_core.numeric import Value, dot, squared
from pmwvc_core.state import Stateful


class EnergyLedger(Stateful):
    """Energy that a wave has carried, sum of |w|^2 dt / 2 [J]; ``(runs, 1)`` in a batch."""

    MEMORY = "energy_j"
    __slots__ = ("energy_j",)

    def __init__(self) -> None:
        self.energy_j: Value = 0.0

    def add(self, wave: Value, dt: float) -> None:
        """Count a wave [sqrt(W)] that lasted dt [s]."""
        self.energy_j = self.energy_j + squared(wave) * (0.5 * dt)


class PortLedger(Stateful):
    """Work done through a port, sum of F . xd dt [J]; ``(runs, 1)`` in a batch."""

    MEMORY = "energy_j"
    __slots__ = ("energy_j",)

    def __init__(self) -> None:
        self.energy_j: Value = 0.0

    def add(self, f: Value, xd: Value, dt: float) -> None:
        """Count a force [N] that moved with xd [m/s] for dt [s]."""
        self.energy_j = self.energy_j + dot(f, xd) * dt
