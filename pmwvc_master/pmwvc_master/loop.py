# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force loop in real time: one thread, one tick per millisecond, one packet per frame.

:class:`pmwvc_core.frame.force_loop.ForceLoop` has the protocol; this file gives it samples,
packets and times on the grid of the monotonic clock that all processes of a machine share. No ROS
here: the wires to the outside are an argument.
"""

import threading
import time
from collections.abc import Callable
from typing import Protocol

from pmwvc_core.frame.force_loop import ForceLoop
from pmwvc_core.numeric import Value
from pmwvc_core.runtime.health import Health
from pmwvc_core.runtime.pacing import Pacer, RealTimeReport, Tick, request_real_time
from pmwvc_core.transport.packet import PacketLink
from pmwvc_master.blocks import Block, TraceBlocks
from pmwvc_master.device_work import DeviceWork
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
    """One user's force loop in time.

    The protocol has receiver, controller, limits and sender; ``tick_s`` is the period [s],
    ``clock`` the monotonic clock [ns].
    """

    def __init__(
        self,
        protocol: ForceLoop,
        device: HapticDevice,
        *,
        wires: Wires,
        tick_s: float,
        dof: int,
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self.protocol = protocol
        self.device = device
        self.wires, self.link = wires, wires.link
        self.tick_s = tick_s
        self.work = DeviceWork(hand_force_known=device.info.hand_force_known)
        self.health = Health()
        self.missed = 0
        self.samples = 0  # of the device, that were new
        self.memory = RealTimeReport()  # granted before the start
        self.report: RealTimeReport | None = None
        self._clock = clock
        self._trace = TraceBlocks(
            protocol.rate_drop, dof, self.work, lambda block: wires.publish_trace(block, self)
        )
        self._first: int | None = None  # grid number of the first tick
        self._coupled = False

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
            self._trace.close(self.protocol.report())
            self._trace.publish()

    def tick(self, tick: Tick) -> None:
        """Run one tick of the grid."""
        protocol = self.protocol
        if self._first is None:
            if tick.grid % protocol.rate_drop:
                return  # begin with a whole frame
            self._first = tick.grid
        starts = protocol.starts_frame(tick.grid)
        self.missed += tick.skipped
        sample = self.device.read(tick.due_ns)
        self.samples += sample.fresh
        self.work.moved(protocol.x, sample)
        if tick.skipped and not starts:
            self._trace.close(protocol.report())
        packets = self.link.take()
        f, packet, row = protocol.tick(tick.grid, self._clock(), sample, packets)
        self.device.write(f)
        if packet is not None:
            self.link.send(packet)
        if starts:
            self._trace.close(protocol.ended)
            self._trace.resize(protocol.rate_drop)
        if protocol.coupled and not self._coupled:
            self._coupled = True
            self.device.couple()
        self.work.held = f, sample.f_h
        in_frame, last = self._trace.count, tick.grid + 1 == protocol.next_frame
        if in_frame == TRACE_TICK or (last and in_frame < TRACE_TICK):
            self._trace.publish()
        if in_frame == MOTION_TICK or (last and in_frame < MOTION_TICK):
            self.wires.publish_motion(sample, f, tick.due_ns)
        compute_ns = self._clock() - tick.woke_ns
        self.health.add(tick.lateness_ns, compute_ns)
        self._trace.put(tick.grid - self._first, tick, row, compute_ns)
