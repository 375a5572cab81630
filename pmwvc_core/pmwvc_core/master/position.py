# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback on the returning wave (App. E, Eq. 3).

v_m <- v_m - K_p e, with e = x_m - x_s - x_ref (``printed``, ``budgeted``) or what of it the waves
on their way do not explain (``integral``). ``printed`` pays for nothing: it can make energy. The
others change v_m only as far as the energy tank of the master pays for it (:mod:`.energy_tank`),
and shorten a packet that it does not. Until the first packet of the server, and while it is
silent, nothing is corrected.

With K_p the link no longer is a spring: at rest v_m and e belong together only for e = 0, so that
the rendered stiffness is the environment's. No passive link without stored energy can do that
(K/M <= 4/tau^2, docs/theory.md, section 11): ``storage_j`` is what the paid forms hold at the
start, and the port is passive with this storage.

Equations: docs/theory.md 9.1, 9.8.
"""

from collections.abc import Mapping
from typing import Any, Protocol

from pmwvc_core.master.energy_tank import EnergyTank
from pmwvc_core.master.position_error import PositionError, PositionResidual
from pmwvc_core.numeric import Value, root, squared, truth
from pmwvc_core.params import MasterParams
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.wave.impedance import impedance_of

ADAPTED = 0.5  # K_p tau / sqrt(2b) of an adapted gain: docs/theory.md, section 9


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


class _AsPublished(Stateful):
    BLOCKS = "_position_error"
    MEMORY = "_spent _there"

    def __init__(self, params: MasterParams) -> None:
        self._position_error = PositionError(params)
        self._spent: Value = 0.0
        self._there = False
        self.configure(params)

    def configure(self, params: MasterParams) -> None:
        self._gain = params.position.gain
        self._tick_s = params.tick_s
        self._position_error.configure(params)

    def on_packet(self, packet: WavePacket) -> None:
        self._position_error.on_packet(packet)

    def receive(self) -> None:
        self._there = True

    def silence(self) -> None:
        self._there = False

    def down(self, v: Value, x: Value) -> Value:
        error = self._position_error.step(x, v)
        if not self._there:
            return v
        changed = v - self._gain * error
        more = squared(changed) - squared(v)
        self._spent = self._spent + more * (0.5 * self._tick_s)
        return changed

    def applied(self, u: Value, f: Value, xd: Value) -> None:
        self._position_error.take(u)

    def send(self, wave: Value, seq: int) -> Value:
        self._position_error.send(wave, wave, seq)
        return wave

    @property
    def accounts(self) -> Mapping[str, Value]:
        return {"position_spent": self._spent}


class _Budgeted(Stateful):
    BLOCKS = "_position_error _tank"
    MEMORY = "_gain _there"

    def __init__(self, params: MasterParams, position_error: PositionError) -> None:
        self._position_error = position_error
        self._tank = EnergyTank(params)
        self._there = False
        self.configure(params)

    def configure(self, params: MasterParams) -> None:
        self._gain = params.position.gain
        self._adapts = params.position.adapts
        self._scale: Any = root(2.0 * impedance_of(params))
        self._position_error.configure(params)
        self._tank.configure(params)

    def on_packet(self, packet: WavePacket) -> None:
        self._tank.on_packet(packet)
        self._position_error.on_packet(packet)
        lag_s = self._position_error.round_trip_s
        if self._adapts and truth(lag_s > 0.0):
            self._gain = (ADAPTED / lag_s) * self._scale

    def receive(self) -> None:
        self._there = True

    def silence(self) -> None:
        self._there = False

    def down(self, v: Value, x: Value) -> Value:
        error = self._position_error.step(x, v)
        self._tank.move(x)
        self._tank.play(v)
        if not self._there:
            return v
        return v + self._tank.spend(v, -(self._gain * error))

    def applied(self, u: Value, f: Value, xd: Value) -> None:
        self._position_error.take(u)
        self._tank.take(u, f, xd)

    def send(self, wave: Value, seq: int) -> Value:
        sent = self._tank.send(wave)
        self._position_error.send(wave, sent, seq)
        return sent

    @property
    def accounts(self) -> Mapping[str, Value]:
        return {
            "position_spent": self._tank.spent_j,
            "position_surplus": self._tank.free_j,
            "position_discarded": self._tank.discarded_j,
            "position_owed": self._tank.owed_j,
        }


def make_position_feedback(params: MasterParams) -> PositionFeedback | None:
    """Return the feedback that the parameters name, or None where there is none."""
    if not params.position.is_on:
        return None
    kind = params.position.feedback
    if kind == "printed":
        return _AsPublished(params)
    return _Budgeted(
        params, PositionError(params) if kind == "budgeted" else PositionResidual(params)
    )
