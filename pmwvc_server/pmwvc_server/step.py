# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A step of the server's loop as observers see it, and what connects the loop to them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

from pmwvc_core.frame.rows import ServerRow
from pmwvc_core.runtime.pacing import Tick
from pmwvc_core.transport.packet import PacketLink, WavePacket

if TYPE_CHECKING:
    from pmwvc_server.loop import ServerLoop


class Step(NamedTuple):
    """A step just made, with the packets of each user taken in at an instant."""

    row: ServerRow
    tick: Tick
    looked_ns: int
    packets: Sequence[Sequence[WavePacket]]
    compute_s: float


class Wires(Protocol):
    """Connections of the loop to the network and to observers."""

    @property
    def links(self) -> Sequence[PacketLink]:
        """The packets of each user."""

    def publish_trace(self, loop: "ServerLoop", step: Step) -> None:
        """Publish a step."""
