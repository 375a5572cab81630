# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback on the returning wave (App. E, Eq. 3)."""

from collections.abc import Mapping
from typing import Protocol

from pmwvc_core.numeric import Value
from pmwvc_core.params import MasterParams
from pmwvc_core.wave.packet import WavePacket


class PositionFeedback(Protocol):
    """What brings device and avatar together. Order: ``send``, ``hear``, ``receive`` once a
    frame; ``down``, ``applied`` every tick.
    """

    def hear(self, packet: WavePacket, x: Value) -> None:
        """Note the newest packet with the avatar's position, and where the device is [m]."""

    def receive(self, wave: Value) -> None:
        """Note the wave taken for the frame that begins [sqrt(W)]."""

    def down(self, v: Value, x: Value) -> Value:
        """Return the wave after the hold with the feedback for the device at ``x`` [m]."""

    def applied(self, u: Value) -> None:
        """Note the wave that left the port in this tick [sqrt(W)]."""

    def send(self, wave: Value) -> Value:
        """Return the wave for the packet of this frame start [sqrt(W)]."""

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies of the feedback since the start, by name [J]; always the same names."""


def make_position_feedback(params: MasterParams) -> PositionFeedback | None:
    """Return the feedback that the parameters name, or None where there is none."""
    return None
