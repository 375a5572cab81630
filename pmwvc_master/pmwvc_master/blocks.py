# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The trace of a force loop: a block of ticks per frame, published while the next frame is under
way; and the work at its device, which the trace holds.
"""

from array import array
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any

from pmwvc_core.ends.inbox import vector
from pmwvc_core.frame import FrameReport, Row
from pmwvc_core.numeric import Value, dot
from pmwvc_core.runtime.messages import PER_AXIS, PER_TICK
from pmwvc_core.runtime.pacing import Tick
from pmwvc_core.traces import ENERGIES
from pmwvc_core.transport.packet import WavePacket
from pmwvc_master.devices import DeviceSample

UINT32 = 0xFFFFFFFF


class DeviceWork:
    """Running sums of the work done at a device by the forces held between its samples [J]."""

    def __init__(self, *, hand_force_known: bool) -> None:
        self.device: Value = 0.0  # of its force against the hand
        self.hand: Value = 0.0  # of the hand on it
        self._hand_force_known = hand_force_known
        self.samples = 0  # that were new
        self.held: tuple[Value, Value] | None = None  # of device and hand, since a sample [N]

    def moved(self, x: Value, sample: DeviceSample) -> None:
        """Take a sample; add the work since the last valid position [m]."""
        self.samples += sample.fresh
        if sample.work is not None:
            self.device, self.hand = sample.work
        elif sample.valid and self.held is not None:
            moved = sample.x - x
            f, f_h = self.held
            self.device = self.device + dot(f, moved)
            if self._hand_force_known:
                self.hand = self.hand + dot(f_h, moved)


class FrameBlock:
    """The ticks of one frame, noted one after the other.

    ``taken`` has tick of the block, number and sender's epoch of each packet given to the
    receiver, in their order.
    """

    first_tick = start_ns = missed = 0  # of the first tick: number, due time [ns]; skipped before
    changes = 0  # frames that took changes over up to this one
    state, reason = 0, ""  # at the end of the frame, as the energies [J]
    energy: Mapping[str, Value] = MappingProxyType({})
    accounts: Mapping[str, Value] = MappingProxyType({})
    orientation: tuple[float, ...] = ()  # likewise

    def __init__(self, dof: int) -> None:
        self._dof = dof
        self.taken: list[tuple[int, int, int]] = []
        self._rows: list[Row] = []
        self._times: list[tuple[float, float, int]] = []

    def __len__(self) -> int:
        return len(self._rows)

    def put(
        self, tick: Tick, signals: Row, compute_ns: int, looked_ns: int,
        packets: Sequence[WavePacket],
    ) -> None:  # fmt: skip
        """Note one tick, its signals, computing time, and packets taken in at an instant [ns]."""
        self.taken += [(len(self), each.seq, each.epoch) for each in packets if not each.refusal]
        self._rows.append(signals)
        after_ns = min(looked_ns - tick.due_ns, UINT32)
        self._times.append((tick.lateness_ns * 1e-9, compute_ns * 1e-9, after_ns))

    def series(self) -> Mapping[str, "array[float]"]:
        """Return what was noted by field name, row-major."""
        found: dict[str, Any] = {}
        signals, times = zip(*self._rows, strict=True), zip(*self._times, strict=True)
        for name, column in zip(PER_AXIS, signals, strict=True):
            found[name] = array("d", [x for value in column for x in vector(value, self._dof)])
        for (name, code), each in zip(PER_TICK.items(), times, strict=True):
            found[name] = array(code, each)
        return found

    def close(self, report: FrameReport, work: DeviceWork) -> None:
        """Note state and energies at the end of the frame."""
        self.state, self.reason = int(report.state), str(report.reason)
        waves = report.u_m, report.u_tx, report.v_rx, report.v_m
        self.energy = dict(zip(ENERGIES, (*waves, work.device, work.hand), strict=True))
        self.accounts, self.orientation = report.accounts, report.orientation


class TraceBlocks:
    """The block that is being filled, and the one before it, which waits to be published.
    ``work`` is that of device and hand so far.
    """

    def __init__(self, dof: int, work: DeviceWork, publish: Callable[[FrameBlock], None]) -> None:
        self._new = partial(FrameBlock, dof)
        self._filled = self._waiting = self._new()
        self._first: int | None = None  # grid number of the first tick
        self._work, self._publish, self._ran = work, publish, 0  # ticks before this block

    def reaches(self, tick: int, *, last: bool) -> bool:
        """Tell whether a tick of a frame is the next one, or would come after its last one."""
        return len(self._filled) == tick or (last and len(self._filled) < tick)

    def block(self, tick: Tick, changes: int) -> FrameBlock:
        """Return the block that a tick is to be noted in."""
        block = self._filled
        self._first = tick.grid if self._first is None else self._first
        if not len(block):
            block.first_tick, block.start_ns = tick.grid - self._first, tick.due_ns
            block.changes, block.missed = changes, block.first_tick - self._ran
        return block

    def close(self, report: FrameReport | None) -> None:
        """Set the block aside for publishing; go on with another one."""
        self._ran += len(self._filled)
        if len(self._filled) and report is not None:
            self.publish()  # still there only after a skip
            self._filled.close(report, self._work)
            self._waiting = self._filled
        self._filled = self._new()

    def publish(self) -> None:
        """Publish the block that waits, where there is one."""
        if len(self._waiting):
            self._publish(self._waiting)
        self._waiting = self._new()
