# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of the frame protocol: receiver, controller, safety limits and sender of one
user.

::

    tick 0 of a frame     the packet: the filter's output of the tick before; changes
    every tick            packets to the receiver; motion -> controller -> limits -> force
    answer tick           the newest wave to the controller, once a frame

Frames begin at the multiples of the rate drop (:class:`.schedule.Frames`); where that changes, one
of them is shorter.
Time is an argument: integer nanoseconds of any monotonic clock.
"""

import math
from collections.abc import Sequence
from typing import Any

from pmwvc_core.frame.device_sample import LATE_NS, STALE_NS, DeviceSample
from pmwvc_core.frame.end import ProtocolEnd, waiting
from pmwvc_core.frame.rows import FrameReport, Row
from pmwvc_core.frame.schedule import Frames
from pmwvc_core.master.controller import MasterController
from pmwvc_core.master.safety.limiter import SafetyLimiter
from pmwvc_core.numeric import Value, truth
from pmwvc_core.params import MasterParams, SafetyParams
from pmwvc_core.transport.packet import FLAG_LEAVING, FLAG_LIMITED, Packer, WavePacket
from pmwvc_core.transport.receiver import Receiver


class ForceLoop(ProtocolEnd):
    """One user's force loop.

    Parameters
    ----------
    controller
        From motion to force and waves.
    inbox
        The receiver of the returning packets.
    packer
        Numbers the outgoing packets and keeps their running sums.
    frames
        When frames start and take their answer.

    Attributes
    ----------
    ended
        State and energies when the last frame ended, its last packet included.
    coupled
        Whether the server had answered and the soft start was over when an answer was taken.
    x
        Last valid position [m].
    late_samples
        Ticks so far with a sample older than ``LATE_NS``, or none.
    """

    BLOCKS = "controller safety inbox packer frames"
    MEMORY = "ended coupled x late_samples _measured_ns _due _events_sent _epoch _timeout_s"

    def __init__(
        self,
        controller: MasterController,
        safety: SafetyLimiter,
        *,
        inbox: Receiver,
        packer: Packer,
        frames: Frames,
        tick_s: float,
    ) -> None:
        super().__init__()
        self.controller, self.safety = controller, safety
        self.inbox = inbox
        self.packer = packer
        self.frames = frames
        self._tick_s = tick_s
        self.ended: FrameReport | None = None
        self.coupled = False
        self.x: Value = 0.0
        self.late_samples = 0
        self._measured_ns: float = -math.inf
        self._events_sent = 0
        self._due = math.inf  # the tick after the last one that ran
        self._timeout_s = inbox.timeout_s
        self._epoch = 0  # of the server whose answers are used

    @property
    def ready(self) -> bool:
        """True once the server has answered and the soft start is over.

        From then on a simulated hand may act against the force that the controller renders;
        before, it would push the device away from its avatar against a force held back.
        """
        return truth(self.safety.ready)

    @property
    def next_frame(self) -> int:
        """Tick with which the next frame starts."""
        return self.frames.next_frame

    @property
    def rate_drop(self) -> int:
        """Ticks of a frame."""
        return self.frames.rate_drop

    def starts(self, tick: int) -> bool:
        """Tell whether a tick is the first of its frame to run."""
        return self.frames.starts(tick)

    @property
    def max_force(self) -> Value:
        """Longest force that the device is given [N]."""
        return self.safety.params.max_force

    @property
    def state(self) -> Any:
        """State of the limits."""
        return self.safety.state

    @property
    def reason(self) -> Any:
        """Why they are in that state."""
        return self.safety.reason

    @property
    def safety_events(self) -> Any:
        """How often the limits intervened."""
        return self.safety.events

    def configure_safety(self, safety: SafetyParams) -> None:
        """Take other limits over."""
        self.safety.configure(safety)

    def rearm(self) -> None:
        """Leave a fault."""
        self.safety.rearm()

    def configure(self, master: MasterParams) -> None:
        """Take other parameters over at a frame start: those of the controller, the rate drop, the
        deadband.
        """
        self.controller.configure(master)
        self.packer.deadband.configure(master.deadband)
        self.frames.configure(master.rate_drop)

    def start_frame(self, tick: int, now_ns: int, sample: DeviceSample) -> WavePacket | None:
        """Return the packet where a frame starts with this tick; None inside a frame, and where
        the deadband holds it back.

        ``tick`` does this itself. A caller whose answers come within the same instant calls it
        before: the packet leaves, the answer arrives, the tick begins.
        """
        frames = self.frames
        if not frames.starts(tick):
            return None
        begun = tick - tick % frames.rate_drop
        if self._age_ns(sample, now_ns) <= STALE_NS:
            self.controller.measure(sample.x, sample.xd)
        packet = self._packed(now_ns)
        self._take_changes()
        self.packer.period = frames.start(tick, begun)
        return packet

    def tick(
        self, tick: int, now_ns: int, sample: DeviceSample, packets: Sequence[WavePacket]
    ) -> tuple[Value, WavePacket | None, Row]:
        """Run one tick.

        Parameters
        ----------
        tick
            Its number; frames start at the multiples of the rate drop.
        sample
            Of the device at the start of the tick. Where it cannot be trusted (not valid, or
            older than ``STALE_NS``), no force is rendered, and after it the force rises from zero.
        packets
            Arrived since the last tick, in the order of arrival.

        Returns
        -------
        tuple
            Force that the device may render until the next tick [N]; packet to send, at a frame
            start; signals of the tick (``SIGNALS``).
        """
        packet = None
        if packets or tick >= self.frames.next_event:
            packet = self._exchange(tick, now_ns, sample, packets)
        if tick > self._due:  # ticks did not run
            self.inbox.playout.pass_by((tick - self._due) * self._tick_s)
        self._due = tick + 1
        x, xd = sample.x, sample.xd
        age_ns = self._age_ns(sample, now_ns)
        self.late_samples += age_ns > LATE_NS
        if age_ns <= STALE_NS:
            sensed, position, velocity = True, x, xd
            self.x = x
        else:  # where it was last seen; its velocity is not known
            sensed, position, velocity = False, self.x, 0.0 * self.x
        controller, inbox = self.controller, self.inbox
        f_m = controller.step(position, velocity)
        if inbox.newest is None:
            f = self.safety.step(f_m, position, velocity, math.inf, False, sensed)
        else:
            silence_s = (now_ns - inbox.accepted_ns) * 1e-9
            interrupted, unreceived = inbox.waits(now_ns)
            f = self.safety.step(
                f_m, position, velocity, silence_s, True, sensed, interrupted, unreceived
            )
        controller.applied(f)
        row = (x, xd, sample.f_h, f_m, f, controller.u_m, controller.u_m_lp, controller.v_m)
        return f, packet, row

    def leave(self, now_ns: int) -> WavePacket:
        """Return the last packet: the user leaves."""
        return self._pack(self.controller.send(), now_ns, FLAG_LEAVING)

    def report(self) -> FrameReport:
        """Return safety state and energies as they are now."""
        safety, port = self.safety, self.controller
        return FrameReport(
            safety.state,
            safety.reason,
            port.energy_u_m,
            port.energy_u_tx,
            port.energy_v_rx,
            port.energy_v_m,
            port.accounts,
        )

    def _exchange(
        self, tick: int, now_ns: int, sample: DeviceSample, packets: Sequence[WavePacket]
    ) -> WavePacket | None:
        """Start a frame, take packets in, take the answer: whatever of it is due."""
        packet = None
        if self.frames.starts(tick):
            packet = self.start_frame(tick, now_ns, sample)
            self.ended = self.report()
        for arrived in packets:
            if not self._refuses(arrived, self.controller.flags):
                self.inbox.push(arrived, now_ns)
        if self.frames.take_answer(tick):
            self._take_answer(now_ns)
        return packet

    def _age_ns(self, sample: DeviceSample, now_ns: int) -> float:
        """Return the time since a sample was measured [ns]; infinite where that is no sample."""
        if sample.fresh:
            self._measured_ns = now_ns if sample.measured_ns is None else sample.measured_ns
        age_ns = now_ns - self._measured_ns
        return age_ns if sample.valid and age_ns >= 0 else math.inf

    def _packed(self, now_ns: int) -> WavePacket | None:
        """Return the next packet: the filter's output after the last tick; None where the deadband
        holds it back.
        """
        wave, flags = self.controller.send(), waiting(self.inbox)
        events = self.safety.events
        if isinstance(events, int) and events != self._events_sent:
            self._events_sent = events
            flags |= FLAG_LIMITED
        if self.packer.holds_back(wave, flags | self.controller.flags):
            return None
        return self._pack(wave, now_ns, flags)

    def _pack(self, wave: Value, now_ns: int, flags: int) -> WavePacket:
        port, inbox = self.controller, self.inbox
        at, account, short = port.position(), port.account(), inbox.playout.short
        flags |= port.flags
        return self.packer.pack(wave, at, now_ns, flags, inbox.echo(now_ns), account, short)

    def _take_answer(self, now_ns: int) -> None:
        """Give the newest wave to the controller; a silent server becomes a matched damper.

        Behind another server than before, the force starts from zero.
        """
        inbox, controller = self.inbox, self.controller
        newest = inbox.newest
        if newest is not None:
            if newest.epoch != self._epoch:
                if self._epoch:
                    self.safety.restart()
                self._epoch = newest.epoch
            controller.on_packet(newest)
        if inbox.timeout_s != self._timeout_s:
            self._timeout_s = inbox.timeout_s
            self.safety.expect(self._timeout_s)
        if newest is None or inbox.silent(now_ns):
            controller.silence()
        else:  # a playout that plays on is stepped by the controller
            frame_s = self.packer.period
            controller.receive(newest.wave if inbox.plays_on else inbox.playout.step(frame_s))
        self.coupled = self.coupled or truth(self.safety.ready)
