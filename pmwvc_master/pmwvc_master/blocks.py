# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The trace of a force loop: a block of ticks per frame, published while the next frame is under
way.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from pmwvc_core.frame.force_loop import FrameReport, Row
from pmwvc_core.numeric import Value
from pmwvc_core.runtime.messages import TraceBlock
from pmwvc_core.runtime.pacing import Tick
from pmwvc_master.device_work import DeviceWork


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


class TraceBlocks:
    """The block that is being filled, and the one before it, which waits to be published.

    A block has ``rate_drop`` ticks of ``dof`` axes; ``work`` is that of device and hand so far.
    """

    def __init__(
        self, rate_drop: int, dof: int, work: DeviceWork, publish: Callable[[Block], None]
    ) -> None:
        self._filled, self._waiting = (Block(rate_drop, dof) for _ in range(2))
        self._dof = dof
        self._work, self._publish = work, publish

    @property
    def count(self) -> int:
        """Ticks in the block that is being filled."""
        return self._filled.count

    def resize(self, rate_drop: int) -> None:
        """Go on with blocks of so many ticks, before the first tick of one."""
        if self._filled.ticks != rate_drop:
            self._filled = Block(rate_drop, self._dof)

    def put(self, number: int, tick: Tick, row: Row, compute_ns: int) -> None:
        """Note a tick: its number from the first one, and its signals."""
        block = self._filled
        if not block.count:
            block.first_tick, block.start_ns = number, tick.due_ns
        block.put(*row, tick.lateness_ns * 1e-9, compute_ns * 1e-9)

    def close(self, report: FrameReport | None) -> None:
        """Set the current block aside for publishing and go on with the other one."""
        if self._filled.count and report is not None:
            self.publish()  # still there only after a skip
            self._filled.close(report, self._work)
            self._filled, self._waiting = self._waiting, self._filled

    def publish(self) -> None:
        """Publish the block that waits, where there is one."""
        if self._waiting.count:
            self._publish(self._waiting)
            self._waiting.clear()
