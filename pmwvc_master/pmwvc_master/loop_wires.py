# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The outside of the force loop: network and observers."""

from typing import TYPE_CHECKING, Protocol

from pmwvc_core.numeric import Value
from pmwvc_core.transport.packet import PacketLink
from pmwvc_master.blocks import Block
from pmwvc_master.devices import DeviceSample

if TYPE_CHECKING:
    from pmwvc_master.loop import MasterLoop


class Wires(Protocol):
    """Connections of the loop to the network and to observers."""

    @property
    def link(self) -> PacketLink:
        """The user's packets."""

    def publish_trace(self, block: Block, loop: "MasterLoop") -> None:
        """Publish the ticks of a frame."""

    def publish_motion(self, sample: DeviceSample, f: Value, due_ns: int) -> None:
        """Publish velocity and force of the device for observers."""
