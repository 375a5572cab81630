# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The change of the returning wave that position feedback asks for: - K_p e (App. E, Eq. 3).

K_p is given, or follows the round trip tau that packets show (``adapts``): K_p = c sqrt(2b)/tau.
Nothing is asked for while the server is silent. Not here: the error e (:mod:`.error`),
and who pays for the change (:mod:`.feedback`, :mod:`.strict`).

Equations: docs/theory.md 9.1, 9.8.
"""

from pmwvc_core.account import Entry, Role
from pmwvc_core.master.position.error import PositionError
from pmwvc_core.numeric import Value, truth
from pmwvc_core.params import MasterParams
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket

SPENT = Entry("position_spent", "released by the position feedback", Role.GIVEN)
ADAPTED = 0.5  # c = K_p tau/sqrt(2b) of an adapted gain


class PositionCorrection(Stateful):
    """Order: ``on_packet``, ``receive`` or ``silence`` once a frame; ``asked`` every tick.

    Parameters
    ----------
    params
        Of the master.
    error
        The position error that it acts on.
    """

    BLOCKS = "_error"
    MEMORY = "_gain _there"

    def __init__(self, params: MasterParams, error: PositionError) -> None:
        self._error = error
        self._there = False
        self.configure(params)

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over; what is known of error and round trip stays."""
        self._gain: Value = params.position.gain
        self._adapts = params.position.adapts
        self._error.configure(params)

    def on_packet(self, packet: WavePacket) -> None:
        """Note the newest packet with the avatar's position."""
        self._error.on_packet(packet)
        lag_s = self._error.round_trip_s
        if self._adapts and truth(lag_s > 0.0):
            self._gain = (ADAPTED / lag_s) * self._error.scale

    def receive(self) -> None:
        """Note that the server is there."""
        self._there = True

    def silence(self) -> None:
        """Note that it is silent."""
        self._there = False

    def asked(self, v: Value, x: Value) -> Value | None:
        """Return - K_p e for the hold's wave v [sqrt(W)] and the device at x [m]; None while the
        server is silent. Once a tick.
        """
        error = self._error.step(x, v)
        return -(self._gain * error) if self._there else None
