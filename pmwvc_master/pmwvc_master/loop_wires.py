# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The outside of the force loop: network and observers, and the block of ticks it publishes."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol

from pmwvc_core.frame.force_loop import FrameReport
from pmwvc_core.numeric import Value
from pmwvc_core.runtime.messages import TraceBlock
from pmwvc_core.transport.packet import PacketLink
from pmwvc_master.device_work import DeviceWork
from pmwvc_master.devices import DeviceSample

if TYPE_CHECKING:
    from pmwvc_master.loop import MasterLoop


class Wires(Protocol):
    """Connections of the loop to the network and to observers."""

    @property
    def link(self) -> PacketLink:
        """The user's packets."""

    def publish_trace(self, block: "Block", loop: "MasterLoop") -> None:
        """Publish the ticks of a frame."""

    def publish_motion(self, sample: DeviceSample, f: Value, due_ns: int) -> None:
        """Publish velocity and force of the device for observers."""


class Block(TraceBlock):
    """The ticks of one frame: number and due time of the first, state and energies at the end."""

    first_tick = 0
    start_ns = 0
    state = 0
    reason = ""
    energy: Mapping[str, Value] = MappingProxyType({})
    accounts: Mapping[str, Value] = MappingProxyType({})

    def close(self, report: FrameReport, work: DeviceWork) -> None:
        """Note state and energies at the end of the frame."""
        self.state, self.reason = int(report.state), str(report.reason)
        self.energy = {
            "u_m": report.u_m,
            "u_tx": report.u_tx,
            "v_rx": report.v_rx,
            "v_m": report.v_m,
            "device": work.device,
            "hand": work.hand,
        }
        self.accounts = report.accounts
