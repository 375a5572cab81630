# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force loop in real time: it gives :class:`pmwvc_core.ends.user_end.UserEnd` samples,
packets and times on the grid of the monotonic clock that all processes of a machine share. No ROS
here: the link and the observers are arguments.
"""

import threading
import time
from collections.abc import Callable
from functools import partial

from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.runtime.pacing import Paced, Pacer, Tick
from pmwvc_core.transport.packet import PacketLink
from pmwvc_master.blocks import DeviceWork, FrameBlock, TraceBlocks
from pmwvc_master.devices import HapticDevice

PRIORITY = 20
TRACE_TICK = 1  # of a frame, that publishes; the last one of a shorter frame


class MasterLoop(Paced):
    """One user's force loop in time: its period ``tick_s`` [s], the monotonic clock [ns]."""

    def __init__(
        self, protocol: UserEnd, device: HapticDevice, *, link: PacketLink,
        publish_trace: Callable[["MasterLoop", FrameBlock], None], tick_s: float, dof: int,
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:  # fmt: skip
        self.protocol, self.device, self.tick_s = protocol, device, tick_s
        self._link, self._clock = link, clock
        self.work = DeviceWork(hand_force_known=device.info.hand_force_known)
        super().__init__()
        self._begun = False
        self._trace = TraceBlocks(dof, self.work, partial(publish_trace, self))

    def run(self, stop: threading.Event) -> None:
        """Tick in this thread until ``stop`` is set; leave in order whatever happens."""
        try:
            self.request(PRIORITY)
            for tick in Pacer(round(self.tick_s * 1e9)).ticks(stop):
                self.tick(tick)
        finally:
            self.leave()

    def leave(self) -> None:
        """Set the device to zero and send the last packet to the server."""
        try:
            self.device.stop()
        finally:
            self._link.send(self.protocol.leave(self._clock()))
            self._trace.close(self.protocol.report())
            self._trace.publish()

    def tick(self, tick: Tick) -> None:
        """Run one tick of the grid."""
        protocol = self.protocol
        if not self._begun and tick.grid % protocol.p.rate_drop:
            return  # begin with a whole frame
        self._begun = True
        starts, coupled = tick.grid >= protocol.s.next_frame, protocol.s.coupled
        self.missed += tick.skipped
        sample = self.device.read(tick.due_ns)
        self.work.moved(protocol.x, sample)
        if tick.skipped and not starts:
            self._trace.close(protocol.report())
        packets = self._link.take()
        looked_ns = self._clock()
        f, packet, row = protocol.tick(tick.grid, looked_ns, sample, packets)
        self.device.write(f)
        if packet is not None:
            self._link.send(packet)
        if starts:
            self._trace.close(protocol.ended)
        if protocol.s.coupled and not coupled:
            self.device.couple()
        self.work.held = f, sample.f_h
        last = tick.grid + 1 == protocol.s.next_frame
        if self._trace.reaches(TRACE_TICK, last=last):
            self._trace.publish()
        compute_ns, changes = self._clock() - tick.woke_ns, protocol.changes
        self.took_ns.extend((tick.lateness_ns, compute_ns))
        self._trace.block(tick, changes).put(tick, row, compute_ns, looked_ns, packets)
