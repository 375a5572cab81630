# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The common part of the devices' ends of all controllers without waves; arriving energy.

They send where the device is and how fast it moves, and keep their accounts in the same places as
the wave controllers do: ``energy_u_...`` is what flowed from the hand into the controller,
``energy_v_...`` what flowed back, both from the force that safety let through times the velocity
at the tick. The wave signals themselves are zero.

Not here: the law, ``receive``, ``step`` and ``silence``.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping

from pmwvc_core.numeric import Value, absolute, dot, finite, maximum, where
from pmwvc_core.params import MasterParams
from pmwvc_core.server.controller import NO_ACCOUNTS
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import FLAG_DIRECT, WavePacket


class DeviceEnd(Stateful, ABC):
    """A master's end without waves, at rest at first."""

    MEMORY = "_x _xd _newest energy_u_m energy_v_m"
    flags = FLAG_DIRECT
    u_m: Value = 0.0
    u_m_lp: Value = 0.0
    v_m: Value = 0.0

    def __init__(self, *, tick_s: float) -> None:
        self._tick_s = tick_s
        self._x: Value = 0.0
        self._xd: Value = 0.0
        self._newest: WavePacket | None = None
        self.energy_u_m: Value = 0.0  # [J] from the device into the controller
        self.energy_v_m: Value = 0.0  # [J] from the controller into the device

    @abstractmethod
    def receive(self, wave: Value) -> None:
        """Take what the newest packet carries, once a frame."""

    @abstractmethod
    def silence(self) -> None:
        """Let go until the next answer."""

    @abstractmethod
    def step(self, x: Value, xd: Value) -> Value:
        """Return the force wanted for the tick that starts with this motion [N]."""

    @property
    def energy_u_tx(self) -> Value:
        """As ``energy_u_m``: no wave is sent that could carry another energy."""
        return self.energy_u_m

    @property
    def energy_v_rx(self) -> Value:
        """As ``energy_v_m``."""
        return self.energy_v_m

    @property
    def accounts(self) -> Mapping[str, Value]:
        """None, unless a controller keeps some."""
        return NO_ACCOUNTS

    def configure(self, params: MasterParams) -> None:
        """Take the tick over, which stays; parameters of the wave port have no meaning here."""
        self._tick_s = params.tick_s

    def on_packet(self, packet: WavePacket) -> None:
        """Note the newest packet."""
        self._newest = packet

    def account(self) -> Value | None:
        """Keep no energy of its own."""
        return None

    def measure(self, x: Value, xd: Value) -> None:
        """Note position [m] and velocity [m/s]; what is not finite counts as the last position and
        as no velocity.
        """
        if not (finite(x) and finite(xd)):
            x = where(absolute(x) < math.inf, x, self._x)
            xd = where(absolute(xd) < math.inf, xd, 0.0)
        self._x, self._xd = x, xd

    def applied(self, f: Value) -> None:
        """Book the force [N] that safety let through."""
        energy = self._tick_s * dot(f, self._xd)
        self.energy_u_m = self.energy_u_m + maximum(energy, 0.0)
        self.energy_v_m = self.energy_v_m + maximum(-energy, 0.0)

    def send(self) -> Value:
        """Return the velocity [m/s] last measured."""
        return self._xd

    def position(self) -> Value:
        """Return the position [m] last measured."""
        return self._x


class Arrivals(Stateful):
    """The receiving end of one peer's running sum of energy [J], which its packets carry.

    A sum makes loss, duplicates and reordering harmless: the newest packet contains all earlier
    ones. Energy sent by an earlier life of the peer, or before its first packet arrived, is not
    counted: it is lost, never gained.
    """

    MEMORY = "_epoch _sum"

    def __init__(self) -> None:
        self._epoch: int | None = None
        self._sum: Value = 0.0

    def take(self, packet: WavePacket) -> Value:
        """Return the energy that this packet brings beyond all before it [J]."""
        if packet.epoch != self._epoch:
            self._epoch, self._sum = packet.epoch, packet.energy
        gained = maximum(packet.energy - self._sum, 0.0)
        self._sum = self._sum + gained
        return gained
