# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy account of a block [J], stated beside the block's law from the signals at its ends.

    taken = given + stored + dissipated + residual

Signals are those of one step, or the rows of a trace ``(..., n, dof)``: then every row is a step,
and energies are ``(..., n, 1)``. Nothing here runs in a loop that controls; accounts are drawn up
from what was recorded.
"""

from typing import NamedTuple

from pmwvc_core.numeric import Value, squared


class Account(NamedTuple):
    """Energy of a block over a step, or since the start.

    Attributes
    ----------
    taken, given
        What came in at one end and went out at the other [J].
    stored
        By how much what the block holds has grown [J].
    dissipated
        Turned into heat, or dropped [J].
    """

    taken: Value
    given: Value = 0.0
    stored: Value = 0.0
    dissipated: Value = 0.0

    @property
    def kept(self) -> Value:
        """Energy taken and not given on [J]; below zero where the block gave out more."""
        return self.taken - self.given

    @property
    def residual(self) -> Value:
        """Energy that storage and dissipation, computed independently, do not explain [J]."""
        return self.kept - self.stored - self.dissipated


def wave_energy(wave: Value, dt: float) -> Value:
    """Return the energy of a wave [sqrt(W)] that lasts dt [s], |w|^2 dt/2 [J]."""
    return squared(wave) * (0.5 * dt)
