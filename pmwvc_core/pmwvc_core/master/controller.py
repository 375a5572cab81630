# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The interface of every controller at the master's end."""

from collections.abc import Mapping
from typing import Protocol

from pmwvc_core.numeric import Value
from pmwvc_core.params import MasterParams
from pmwvc_core.transport.packet import WavePacket


class MasterController(Protocol):
    """Turns the device's motion into force and packets. Order within a frame: ``send``,
    ``on_packet``, ``receive``, then per tick ``step`` and ``applied``.

    Attributes
    ----------
    u_m, u_m_lp, v_m
        Wave out before and after the filter, wave in after the hold [sqrt(W)]; zero where a
        controller has no waves.
    energy_u_m, energy_u_tx, energy_v_rx, energy_v_m
        Running sums of |w|^2/2 times the period [J].
    flags
        ``FLAG_*`` of the packet.
    """

    u_m: Value
    u_m_lp: Value
    v_m: Value
    flags: int

    @property
    def energy_u_m(self) -> Value:
        """Energy of the outgoing wave before the filter [J]."""

    @property
    def energy_u_tx(self) -> Value:
        """Energy sent [J]."""

    @property
    def energy_v_rx(self) -> Value:
        """Energy received [J]."""

    @property
    def energy_v_m(self) -> Value:
        """Energy of the returning wave after the hold [J]."""

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over at a frame start; the tick stays."""

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies that only this controller keeps, by name [J]; always the same names."""

    def account(self) -> Value | None:
        """Return the running sum for the packet [J]; None: that of the waves sent."""

    def on_packet(self, packet: WavePacket) -> None:
        """Note the newest packet, once a frame before ``receive`` or ``silence``."""

    def receive(self, wave: Value) -> None:
        """Take the newest wave, once a frame."""

    def silence(self) -> None:
        """Take a wave of zero instead, once a frame."""

    def measure(self, x: Value, xd: Value) -> None:
        """Note position [m] and velocity [m/s] at a frame start, for ``send`` and ``position``."""

    def step(self, x: Value, xd: Value) -> Value:
        """Return the force wanted for the tick that starts with this motion [N]."""

    def applied(self, f: Value) -> None:
        """Finish the tick with the force that safety let through [N]."""

    def send(self) -> Value:
        """Return the wave for the packet of this frame start."""

    def position(self) -> Value:
        """Return the position for the packet [m]."""
