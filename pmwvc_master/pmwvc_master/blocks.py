# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The trace of a force loop: a block of ticks per frame, published while the next frame is under
way.
"""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol

from pmwvc_core.frame.rows import FrameReport, Row
from pmwvc_core.numeric import Value
from pmwvc_core.runtime.messages import TraceBlock
from pmwvc_core.runtime.pacing import Tick
from pmwvc_core.transport.packet import PacketLink, WavePacket
from pmwvc_master.device_work import DeviceWork
from pmwvc_master.devices import DeviceSample

if TYPE_CHECKING:
    from pmwvc_master.loop import MasterLoop


class Block(TraceBlock):
    """The ticks of one frame: number and due time of the first, frames that took changes over up
    to this one, state and energies at the end.
    """

    first_tick = 0
    start_ns = 0
    changes = 0
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


class Wires(Protocol):
    """Connections of the loop to the network and to observers."""

    @property
    def link(self) -> PacketLink:
        """The user's packets."""

    def publish_trace(self, block: Block, loop: "MasterLoop") -> None:
        """Publish the ticks of a frame."""

    def publish_motion(self, sample: DeviceSample, f: Value, due_ns: int) -> None:
        """Publish velocity and force of the device for observers."""


class TraceBlocks:
    """The block that is being filled, and the one before it, which waits to be published.

    A block has ``rate_drop`` ticks of ``dof`` axes; ``work`` is that of device and hand so far.
    """

    def __init__(
        self, rate_drop: int, dof: int, work: DeviceWork, publish: Callable[[Block], None]
    ) -> None:
        self._filled, self._waiting = (Block(rate_drop, dof) for _ in range(2))
        self._dof = dof
        self._first: int | None = None  # grid number of the first tick
        self._work, self._publish = work, publish

    def reaches(self, tick: int, *, last: bool) -> bool:
        """Tell whether a tick of a frame is the next one, or would come after its last one."""
        count = self._filled.count
        return count == tick or (last and count < tick)

    def put(
        self,
        tick: Tick,
        row: Row,
        compute_ns: int,
        *,
        looked_ns: int,
        packets: Sequence[WavePacket],
        changes: int,
    ) -> None:
        """Note a tick, its signals and the packets taken in at an instant [ns]."""
        block = self._filled
        if self._first is None:
            self._first = tick.grid
        if not block.count:
            block.first_tick, block.start_ns = tick.grid - self._first, tick.due_ns
            block.changes = changes
        late_s, took_s = tick.lateness_ns * 1e-9, compute_ns * 1e-9
        block.put(*row, late_s, took_s, looked_ns - tick.due_ns, packets)

    def close(self, report: FrameReport | None, rate_drop: int) -> None:
        """Set the block aside for publishing; go on with the other one, of so many ticks."""
        if self._filled.count and report is not None:
            self.publish()  # still there only after a skip
            self._filled.close(report, self._work)
            self._filled, self._waiting = self._waiting, self._filled
        if self._filled.ticks != rate_drop:
            self._filled = Block(rate_drop, self._dof)

    def publish(self) -> None:
        """Publish the block that waits, where there is one."""
        if self._waiting.count:
            self._publish(self._waiting)
            self._waiting.clear()
