# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force loop: one thread, one tick per millisecond, one packet per frame of M ticks.

What a tick computes is in :class:`pmwvc_core.master.client.Client`; this file decides *when*, on
the grid of the monotonic clock that all processes of a machine share::

    tick 0 of a frame   send the filter's output, take new settings over
    every tick          take what has arrived; device -> controller -> limits -> device
    tick 4              hand the newest answer to the controller (the server steps at 2 ms)
    tick 1 (next frame) publish the trace of the frame before

With frames shorter than 5 ticks the answer is taken at the last tick. Compared with an answer in
the same instant this adds the 4 ms to the round trip. No ROS here: the wires to the outside are
an argument.
"""

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Protocol

from pmwvc_core.master.client import Client
from pmwvc_core.numeric import Value, dot
from pmwvc_core.runtime.health import Health
from pmwvc_core.runtime.messages import TraceBlock
from pmwvc_core.runtime.pacing import Pacer, RealTimeReport, Tick, request_real_time
from pmwvc_core.transport.packet import FLAG_DIRECT, WavePacket
from pmwvc_master.devices import STALE_S, DeviceSample, HapticDevice

# After the frame start: the server's step at 2 ms and two ways through a relay fit in.
ANSWER_S = 0.004
PRIORITY = 20
STALE_NS = round(STALE_S * 1e9)


class Wires(Protocol):
    """What joins the loop to the network and to those who watch."""

    def take(self) -> WavePacket | None:
        """Return the next packet that has arrived, or None; never wait."""

    def send(self, packet: WavePacket) -> None:
        """Send a packet to the server."""

    def publish_trace(self, block: "Block", loop: "MasterLoop") -> None:
        """Publish the ticks of a frame."""

    def publish_motion(self, sample: DeviceSample, f: Value, due_ns: int) -> None:
        """Publish velocity and force of the device for those who watch."""


class Block(TraceBlock):
    """The ticks of one frame: number and due time of the first, how things stood at the end."""

    first_tick = 0
    start_ns = 0
    state = 0
    reason = ""
    energy: Mapping[str, Value] = MappingProxyType({})
    accounts: Mapping[str, Value] = MappingProxyType({})


class MasterLoop:
    """One user's force loop.

    Parameters
    ----------
    client
        Receiver, controller, limits and sender.
    device
        The haptic device, opened.
    wires
        The outside.
    tick_s, rate_drop, dof
        Period of the loop [s], ticks per frame, axes.
    clock
        The monotonic clock [ns].
    """

    def __init__(
        self,
        client: Client,
        device: HapticDevice,
        *,
        wires: Wires,
        tick_s: float,
        rate_drop: int,
        dof: int,
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self.client = client
        self.inbox = client.inbox
        self.device = device
        self.wires = wires
        self.tick_s = tick_s
        self.ticks = rate_drop
        self.answer_tick = min(round(ANSWER_S / tick_s), rate_drop - 1)
        self.trace_tick = min(1, rate_drop - 1)
        self.motion_tick = min(2, rate_drop - 1)
        self.health = Health()
        self.missed = 0
        self.foreign = 0  # packets of another kind of controller
        self.energy_device: Value = 0.0  # [J] work of the device force against the hand
        self.energy_hand: Value = 0.0  # [J] work of the hand on the device
        self.samples = 0  # of the device, that were new
        self.report: RealTimeReport | None = None
        self._changes: deque[Callable[[], None]] = deque()
        self._clock = clock
        self._block = Block(rate_drop, dof)
        self._done = Block(rate_drop, dof)
        self._first = -1  # grid number of the first tick
        self._frame = -1
        self._answered = False
        self._coupled = False
        self._x: Value = 0.0  # [m] last valid position
        self._held: tuple[Value, Value] | None = None  # [N] of device and hand since then
        self._watched = device.info.pacing in ("device", "event")
        self._fresh_ns = 0  # when something new came last

    def run(self, stop: threading.Event) -> None:
        """Tick in this thread until ``stop`` is set; leave in order whatever happens."""
        try:
            self.report = request_real_time(PRIORITY)
            for tick in Pacer(round(self.tick_s * 1e9)).ticks(stop):
                self.tick(tick)
        finally:
            self.leave()

    def hand_over(self, change: Callable[[], None]) -> None:
        """Have the loop make a change at its next frame start; called by another thread."""
        self._changes.append(change)

    def leave(self) -> None:
        """Set the device to zero and say goodbye to the server."""
        try:
            self.device.stop()
        finally:
            self.wires.send(self.client.send(self._clock(), leaving=True))
            self._close_block()
            self._publish_block(self._done)

    def tick(self, tick: Tick) -> None:
        """Run one tick of the grid."""
        frame, place = divmod(tick.grid, self.ticks)
        if self._first < 0:
            if place:
                return  # begin with a whole frame
            self._first = tick.grid
        self.missed += tick.skipped
        sample = self.device.read(tick.due_ns)
        self._count_work(sample)
        if frame != self._frame:
            self._begin_frame(frame, sample)
        elif tick.skipped:
            self._close_block()
        self._listen(place)
        f = self._control(sample, tick)
        if place == self.trace_tick:
            self._publish_block(self._done)
        if place == self.motion_tick:
            self.wires.publish_motion(sample, f, tick.due_ns)
        self._note(tick, sample, f)

    def _begin_frame(self, frame: int, sample: DeviceSample) -> None:
        """Send, and take over what another thread has prepared."""
        self._frame = frame
        self._answered = False
        if sample.valid:
            self.client.controller.measure(sample.x, sample.xd)
        self.wires.send(self.client.send(self._clock()))
        self._close_block()
        while self._changes:
            self._changes.popleft()()

    def _listen(self, place: int) -> None:
        """Take in what has arrived; once a frame let the controller have the newest of it."""
        while (packet := self.wires.take()) is not None:
            if (packet.flags ^ self.client.controller.flags) & FLAG_DIRECT:
                self.foreign += 1
            else:
                self.inbox.push(packet, self._clock())
        if place >= self.answer_tick and not self._answered:
            self._answered = True
            self.client.receive(self._clock())
            if not self._coupled and self.client.ready():
                self._coupled = True
                self.device.couple()

    def _control(self, sample: DeviceSample, tick: Tick) -> Value:
        """From motion to the force that the device renders until the next tick."""
        if sample.fresh or not self._watched:
            self._fresh_ns = tick.due_ns
            self.samples += 1
        sensed = sample.valid and tick.due_ns - self._fresh_ns <= STALE_NS
        if sensed:
            self._x, xd = sample.x, sample.xd
        else:  # where it was last seen; its velocity is unknown, and no force is rendered
            xd = 0.0 * self._x
        f = self.client.step(self._x, xd, tick.woke_ns, sensed=sensed)
        self.device.write(f)
        self._held = f, sample.f_h
        return f

    def _count_work(self, sample: DeviceSample) -> None:
        """Count the work of the forces held since the last tick."""
        if sample.work is not None:
            self.energy_device, self.energy_hand = sample.work
        elif sample.valid and self._held is not None:
            moved = sample.x - self._x
            f, f_h = self._held
            self.energy_device = self.energy_device + dot(f, moved)
            if self.device.info.hand_force_known:
                self.energy_hand = self.energy_hand + dot(f_h, moved)

    def _note(self, tick: Tick, sample: DeviceSample, f: Value) -> None:
        """Write the tick into the trace."""
        block, controller = self._block, self.client.controller
        if not block.count:
            block.first_tick = tick.grid - self._first
            block.start_ns = tick.due_ns
        compute_ns = self._clock() - tick.woke_ns
        self.health.add(tick.lateness_ns, compute_ns)
        block.put(
            sample.x,
            sample.xd,
            sample.f_h,
            self.client.f_asked,
            f,
            controller.u_m,
            controller.u_m_lp,
            controller.v_m,
            tick.lateness_ns * 1e-9,
            compute_ns * 1e-9,
        )

    def _close_block(self) -> None:
        """Set the current block aside for publishing and go on with the other one.

        It is published when the next frame is under way: state and energies are noted now.
        """
        if self._block.count:
            self._publish_block(self._done)  # still there only after a skip
            controller, safety, block = self.client.controller, self.client.safety, self._block
            block.state, block.reason = int(safety.state), str(safety.reason)
            block.energy = {
                "u_m": controller.energy_u_m,
                "u_tx": controller.energy_u_tx,
                "v_rx": controller.energy_v_rx,
                "v_m": controller.energy_v_m,
                "device": self.energy_device,
                "hand": self.energy_hand,
            }
            block.accounts = controller.accounts
            self._block, self._done = self._done, self._block

    def _publish_block(self, block: Block) -> None:
        if block.count:
            self.wires.publish_trace(block, self)
            block.clear()
