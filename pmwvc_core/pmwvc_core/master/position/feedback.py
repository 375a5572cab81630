# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback on the returning wave of the plain channel.

The wave changes by - K_p e (:mod:`.correction`), with e = x_m - x_s - x_ref (``printed``,
``budgeted``) or what of it the waves on their way do not explain (``integral``). ``printed`` pays
for nothing: it can make energy. The others change v_m only as far as the energy tank of the master
pays for it (:mod:`.energy_tank`), and shorten a packet that it does not.

With K_p the link no longer is a spring: at rest v_m and e belong together only for e = 0, so that
the rendered stiffness is the environment's. No passive link without stored energy can do that
(K/M <= 4/tau^2, docs/theory.md, section 11): ``storage_j`` is what the paid forms hold at the
start, and the port is passive with this storage.
"""

from collections.abc import Mapping
from typing import Protocol

from pmwvc_core.account import Entry, Role
from pmwvc_core.master.position.correction import SPENT, PositionCorrection
from pmwvc_core.master.position.energy_tank import EnergyTank
from pmwvc_core.master.position.error import PositionError, PositionResidual
from pmwvc_core.numeric import Value, squared
from pmwvc_core.params import MasterParams
from pmwvc_core.transport.packet import WavePacket

STORED = Entry("position_surplus", "energy tank of the position feedback", Role.LEVEL)
DISCARDED = Entry("position_discarded", "energy above the cap of the tank, discarded", Role.LEVEL)
DEFICIT = Entry("position_owed", "returned by the hold before its packet arrived", Role.LEVEL)
ENTRIES = (SPENT, STORED, DISCARDED, DEFICIT)


class PositionFeedback(Protocol):
    """Brings device and avatar together. Order: ``send``, ``on_packet``, ``receive`` or
    ``silence`` once a frame; ``down``, ``applied`` every tick.
    """

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over; what is known and saved stays."""

    def on_packet(self, packet: WavePacket) -> None:
        """Note the newest packet with the avatar's position."""

    def receive(self) -> None:
        """Note that the server is there."""

    def silence(self) -> None:
        """Note that it is silent."""

    def down(self, v: Value, x: Value) -> Value:
        """Return the wave after the hold with the feedback for the device at ``x`` [m]."""

    def applied(self, u: Value, f: Value, xd: Value) -> None:
        """Note the wave that goes to the filter in this tick [sqrt(W)], the device's force [N]
        and velocity [m/s].
        """

    def send(self, wave: Value, seq: int) -> Value:
        """Return the wave for packet number ``seq`` [sqrt(W)]."""

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies of the feedback since the start, by name [J]; always the same names."""


class _AsPublished(PositionCorrection):
    MEMORY = "_spent"

    def __init__(self, params: MasterParams) -> None:
        self._spent: Value = 0.0
        super().__init__(params, PositionError(params))

    def configure(self, params: MasterParams) -> None:
        super().configure(params)
        self._tick_s = params.tick_s

    def down(self, v: Value, x: Value) -> Value:
        change = self.asked(v, x)
        if change is None:
            return v
        changed = v + change
        more = squared(changed) - squared(v)
        self._spent = self._spent + more * (0.5 * self._tick_s)
        return changed

    def applied(self, u: Value, f: Value, xd: Value) -> None:
        self._error.take(u)

    def send(self, wave: Value, seq: int) -> Value:
        self._error.send(wave, wave, seq)
        return wave

    @property
    def accounts(self) -> Mapping[str, Value]:
        return {SPENT.name: self._spent}


class _Budgeted(PositionCorrection):
    BLOCKS = "_tank"

    def __init__(self, params: MasterParams, error: PositionError) -> None:
        self._tank = EnergyTank(params)
        super().__init__(params, error)

    def configure(self, params: MasterParams) -> None:
        super().configure(params)
        self._tank.configure(params)

    def on_packet(self, packet: WavePacket) -> None:
        super().on_packet(packet)
        self._tank.on_packet(packet)

    def down(self, v: Value, x: Value) -> Value:
        change = self.asked(v, x)
        self._tank.move(x)
        self._tank.play(v)
        return v if change is None else v + self._tank.spend(v, change)

    def applied(self, u: Value, f: Value, xd: Value) -> None:
        self._error.take(u)
        self._tank.take(u, f, xd)

    def send(self, wave: Value, seq: int) -> Value:
        sent = self._tank.send(wave)
        self._error.send(wave, sent, seq)
        return sent

    @property
    def accounts(self) -> Mapping[str, Value]:
        return {
            SPENT.name: self._tank.spent_j,
            STORED.name: self._tank.free_j,
            DISCARDED.name: self._tank.discarded_j,
            DEFICIT.name: self._tank.deficit_j,
        }


def make_position_feedback(params: MasterParams) -> PositionFeedback | None:
    """Return the feedback that the parameters name, or None where there is none."""
    if not params.position.is_on:
        return None
    if params.position.as_published:
        return _AsPublished(params)
    error = PositionResidual if params.position.of_residual else PositionError
    return _Budgeted(params, error(params))
