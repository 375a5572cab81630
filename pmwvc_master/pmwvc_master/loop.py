# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force loop in real time: it gives :class:`pmwvc_core.ends.user_end.UserEnd` samples,
packets and times on the grid of the monotonic clock that all processes of a machine share. No ROS
here: the wires to the outside are an argument.
"""

import threading
import time
from collections.abc import Callable
from typing import Protocol

from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.numeric import Value
from pmwvc_core.runtime.pacing import Health, Pacer, Tick
from pmwvc_core.runtime.real_time import RealTimeReport, request_real_time
from pmwvc_core.transport.packet import PacketLink
from pmwvc_master.blocks import Block, DeviceWork, TraceBlocks
from pmwvc_master.devices import DeviceSample, HapticDevice

PRIORITY = 20
TRACE_TICK, MOTION_TICK = 1, 2  # of a frame, that publish; the last one of a shorter frame


class Wires(Protocol):
    """Connections of the loop to the network and to observers."""

    @property
    def link(self) -> PacketLink:
        """The user's packets."""

    def publish_trace(self, block: Block, loop: "MasterLoop") -> None:
        """Publish the ticks of a frame."""

    def publish_motion(self, sample: DeviceSample, f: Value, due_ns: int) -> None:
        """Publish velocity and force of the device for observers."""


class MasterLoop:
    """One user's force loop in time: its period ``tick_s`` [s], the monotonic clock [ns]."""

    def __init__(
        self,
        protocol: UserEnd,
        device: HapticDevice,
        *,
        wires: Wires,
        tick_s: float,
        dof: int,
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self.protocol, self.device, self.tick_s = protocol, device, tick_s
        self.wires, self.link = wires, wires.link
        self.work = DeviceWork(hand_force_known=device.info.hand_force_known)
        self.health, self.missed = Health(), 0
        self.memory = RealTimeReport()  # granted before the start
        self.report: RealTimeReport | None = None
        self._clock = clock
        ticks = protocol.rate_drop
        self._trace = TraceBlocks(ticks, dof, self.work, lambda b: wires.publish_trace(b, self))
        self._begun = False

    def run(self, stop: threading.Event) -> None:
        """Tick in this thread until ``stop`` is set; leave in order whatever happens."""
        try:
            self.report = self.memory + request_real_time(PRIORITY)
            for tick in Pacer(round(self.tick_s * 1e9)).ticks(stop):
                self.tick(tick)
        finally:
            self.leave()

    def leave(self) -> None:
        """Set the device to zero and send the last packet to the server."""
        try:
            self.device.stop()
        finally:
            self.link.send(self.protocol.leave(self._clock()))
            self._trace.close(self.protocol.report(), self.protocol.rate_drop)
            self._trace.publish()

    def tick(self, tick: Tick) -> None:
        """Run one tick of the grid."""
        protocol = self.protocol
        if not self._begun and tick.grid % protocol.rate_drop:
            return  # begin with a whole frame
        self._begun = True
        starts, coupled = protocol.starts(tick.grid), protocol.coupled
        self.missed += tick.skipped
        sample = self.device.read(tick.due_ns)
        self.work.moved(protocol.x, sample)
        if tick.skipped and not starts:
            self._trace.close(protocol.report(), protocol.rate_drop)
        packets = self.link.take()
        looked_ns = self._clock()
        f, packet, row = protocol.tick(tick.grid, looked_ns, sample, packets)
        self.device.write(f)
        if packet is not None:
            self.link.send(packet)
        if starts:
            self._trace.close(protocol.ended, protocol.rate_drop)
        if protocol.coupled and not coupled:
            self.device.couple()
        self.work.held = f, sample.f_h
        last = tick.grid + 1 == protocol.next_frame
        if self._trace.reaches(TRACE_TICK, last=last):
            self._trace.publish()
        if self._trace.reaches(MOTION_TICK, last=last):
            self.wires.publish_motion(sample, f, tick.due_ns)
        compute_ns = self._clock() - tick.woke_ns
        self.health.add(tick.lateness_ns, compute_ns)
        changes = protocol.changes
        self._trace.put(
            tick, row, compute_ns, looked_ns=looked_ns, packets=packets, changes=changes
        )
