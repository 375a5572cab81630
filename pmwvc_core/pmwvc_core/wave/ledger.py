# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Running sums of energy at a wave and at a force-velocity port.

Plain sums: a day at 1 kHz adds 1e8 terms, and the rounding of all of them stays below 1e-8 of the
sum, far less than a sensor can resolve. The account of a wave port compares the two.
"""

from pmwvc_core.account import Account, wave_energy
from pmwvc_core.numeric import Value, dot, squared, where
from pmwvc_core.state import Stateful
from pmwvc_core.wave.transform import WavePort

SAME_N = 1e-9  # forces closer than this are the same
SAME_ROOT_W = 1e-9


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


def port_account(
    f: Value,
    f_m: Value,
    xd: Value,
    waves: tuple[Value, Value],
    port: WavePort,
    dt: float,
    beside: Value = 0.0,
) -> Account:
    """Return the energy of a device's wave port and its safety limits over a tick [J].

    ::

        taken       F xd dt, with the force that the limits let through
        given       (|u_m|^2 - |v_m|^2) dt/2, to the waves, and what goes ``beside`` them
        dissipated  the difference in ticks whose force was changed or whose wave was shortened

    Parameters
    ----------
    f, f_m
        Force applied and force wanted [N].
    xd
        Velocity [m/s].
    waves
        u_m and v_m [sqrt(W)].
    beside
        Energy that a filter of the velocity in the force kept [J].
    """
    u_m, v_m = waves
    taken = dot(f, xd) * dt
    given = wave_energy(u_m, dt) - wave_energy(v_m, dt) + beside
    limited = squared(f - f_m) > SAME_N**2
    limited = limited | (squared(u_m - port.u(xd, v_m)) > SAME_ROOT_W**2)
    return Account(taken, given, dissipated=where(limited, taken - given, 0.0))
