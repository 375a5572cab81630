# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of a session, with packets, changes and observers; and a simulated device with
a hand on it, as a force loop meets it. The order is that of :mod:`pmwvc_core.law.user_tick`;
changes are taken over with the packet of a frame.

What is sensed of the device at the start of a tick is the sample; then the controller's force is
held for the tick. Time is an argument: integer nanoseconds of any monotonic clock.
"""

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from pmwvc_core.controllers.library import accounts_of_user
from pmwvc_core.ends.inbox import Inbox, PortEnd, message, value, vector
from pmwvc_core.frame import AT_ONCE, DeviceSample, FrameReport, FrameSchedule, Row
from pmwvc_core.law.port.master import port_energies, port_signals
from pmwvc_core.law.safety.limits import NONE
from pmwvc_core.law.user_tick import NEVER_NS, Sample, begin, send, user_tick
from pmwvc_core.law.vectors import Vector, minus, scaled, zero
from pmwvc_core.made.user import changed_user, made_user
from pmwvc_core.master.safety import state_of, text_of
from pmwvc_core.numeric import AXES, Value
from pmwvc_core.params import DeviceParams
from pmwvc_core.plant.device import device_step, resting_device, simulated_params
from pmwvc_core.plant.forces import hand_force
from pmwvc_core.plant.remote_hand import remote_target
from pmwvc_core.quaternions import IDENTITY, Orientation, carried
from pmwvc_core.scenario.scenario import User
from pmwvc_core.transport.packet import FLAG_LIMITED, WavePacket
from pmwvc_core.unrolled import unrolled


class UserEnd(PortEnd):
    """One user's force loop.

    ``session`` has controller, channel, axes and server (a scenario, or what a node was given),
    ``epoch`` is the number of this life of the sender, ``schedule`` the phases of a frame.
    ``inbox`` receives the returning packets, ``ended`` has state and energies when the last frame
    ended.
    """

    def __init__(
        self, user: User, session: Any, *, epoch: int, schedule: FrameSchedule = AT_ONCE
    ) -> None:
        self._user, self._session, self._epoch, self._dof = user, session, epoch, session.dof
        self._schedule = schedule
        self._accounts: list[str] = []
        self.s, self.p = self._made()
        times_s = {"period_s": session.server.period_s, "timeout_s": user.safety.timeout_s}
        self.inbox = Inbox(session, user.impedance, from_server=True, **times_s)
        super().__init__([self.inbox])
        self._tick, self._send, self._begin = (
            unrolled(law, self._dof) for law in (user_tick, send, begin)
        )
        self.ended: FrameReport | None = None
        self._measured_ns = NEVER_NS
        self._at = self.s.x  # of which the orientation is
        self.orientation: Orientation = IDENTITY if self._dof == AXES else ()

    def _made(self) -> Any:
        """Return the loop as it would begin; name the port's energies, which only grow."""
        master, of = self._user.master, self._session
        kept = accounts_of_user(of.controller, of.channel, master)
        if len(kept) >= len(self._accounts):
            self._accounts = [entry.name for entry in kept]
        answer_tick = self._schedule.answer_tick(tick_s=master.tick_s, rate_drop=master.rate_drop)
        return made_user(self._user, of, answer_tick=answer_tick)

    def configure(self, **groups: Any) -> None:
        """Take other parameters over, at a frame start: ``master``, ``safety``."""
        old, self._user = self._user, dataclasses.replace(self._user, **groups)
        self.s, self.p = changed_user(self.s, self.p, self._made(), old, self._user)
        self.inbox.silence_ns = self.s.arrivals.silence.limit_ns

    def rearm(self) -> None:
        """Leave a fault; the force starts from zero again."""
        self.s = self.s._replace(limits=self.s.limits._replace(fault=NONE))

    def start_frame(self, tick: int, now_ns: int, sample: DeviceSample) -> WavePacket | None:
        """Return the packet where a frame starts with this tick; None inside a frame, and where
        the deadband holds it back. For a caller whose answers come within the same instant, before
        ``tick``.
        """
        if tick < self.s.next_frame:
            return None
        packet = self._sent(now_ns, self._known(sample, now_ns), leaves=False)
        self._take_changes()
        self.s = self._begin(self.s, tick, self.p)
        return packet

    def tick(
        self, tick: int, now_ns: int, sample: DeviceSample, packets: Sequence[WavePacket]
    ) -> tuple[Value, WavePacket | None, Row]:
        """Run the tick of a number; frames start at the multiples of the rate drop. ``sample`` is
        of the device at its start (no force where it is not valid, or older than ``STALE_NS``),
        ``packets`` arrived since the last tick, in that order.

        Return the force that the device may render until the next tick [N], the packet to send at
        a frame start, and the signals of the tick (``SIGNALS``).
        """
        packet = None
        if tick >= self.s.next_frame:
            packet = self.start_frame(tick, now_ns, sample)
            self.ended = self.report()
        taken = self.inbox.take(packets, now_ns) if packets else None
        sensed = self._known(sample, now_ns)
        self.s, f_m, f = self._tick(self.s, tick, now_ns, sensed, taken, self.p)
        if taken:
            self.inbox.silence_ns = self.s.arrivals.silence.limit_ns
        self._turn(self.s.x)
        u_m, u_m_lp, v_m = port_signals(self.s.port)
        applied, arrays = value(f), (value(u_m), value(u_m_lp), value(v_m))
        return applied, packet, (sample.x, sample.xd, sample.f_h, value(f_m), applied, *arrays)

    def leave(self, now_ns: int) -> WavePacket:
        """Return the last packet: the user leaves."""
        x = self.s.x
        packet = self._sent(now_ns, Sample(x, x, False, NEVER_NS, False), leaves=True)
        assert packet is not None  # no deadband holds a goodbye back
        return packet

    def _known(self, sample: DeviceSample, now_ns: int) -> Sample:
        """Return a sample as the laws have it."""
        if sample.fresh:
            self._measured_ns = now_ns if sample.measured_ns is None else sample.measured_ns
        x, xd = vector(sample.x, self._dof), vector(sample.xd, self._dof)
        if sample.orientation and sample.valid:
            self._at, self.orientation = x, sample.orientation
        return Sample(x, xd, sample.valid, self._measured_ns, sample.outside)

    def _turn(self, x: Vector) -> None:
        """Go on to a position; a device that knows its orientation is there already."""
        if self.orientation and x != self._at:
            turn = scaled(minus(x, self._at)[3:], 1.0 / self._session.server.lever_m)
            self._at, self.orientation = x, carried(self.orientation, turn)

    def _sent(self, now_ns: int, sample: Sample, *, leaves: bool) -> WavePacket | None:
        echo, before = self.inbox.echo(now_ns), self.s.packing.events
        self.s, packet, sends = self._send(self.s, now_ns, sample, leaves, self.p)
        if not sends:
            return None
        limited = self.s.limits.events != before and not leaves
        self._turn(packet.position)
        about = self.inbox.flags | limited * FLAG_LIMITED, echo, self.orientation
        return message(packet, self._epoch, *about)

    @property
    def x(self) -> Value:
        """Last valid position [m]."""
        return value(self.s.x)

    @property
    def state(self) -> int:
        """State of the limits."""
        return int(state_of(self.s.limits.cause))

    @property
    def reason(self) -> str:
        """Why they are in that state."""
        return str(text_of(self.s.limits.cause, self._user.given_safety))

    def report(self) -> FrameReport:
        """Return safety state and energies as they are now."""
        s = self.s
        energies = port_energies(s.port, s.arrivals, self.p.port)
        accounts = dict(zip(self._accounts, energies[4:], strict=False))
        about = self.state, self.reason, *energies[:4], accounts, self.orientation
        return FrameReport._make(about)


# Time that a loop misses passes with the last force held, then the device stands still.
CATCH_UP_S = 0.1
Target: TypeAlias = Value | None  # of a remote hand [m]; None lets go


class DevicePlant:
    """A device and the hand on it; ParameterError where it starts outside its workspace."""

    def __init__(
        self, device: DeviceParams, hand: tuple[Any, Any], start: Vector, *, tick_s: float
    ) -> None:
        self._p = simulated_params(device, tick_s)
        self.s = resting_device(start, self._p)
        self.hand, self._of_hand = hand
        self._take: Callable[[], Sequence[Target]] | None = None
        self._axes, self._f_h = len(start), zero(start)
        laws = device_step, hand_force
        self._device_step, self._hand_force = (unrolled(law, self._axes) for law in laws)
        self.sample = DeviceSample(value(self.s.read_x), value(self.s.read_xd), work=(0.0, 0.0))

    def listen(self, take: Callable[[], Sequence[Target]]) -> None:
        """Have a remote hand follow the targets that a call returns, new ones each."""
        self.hand, self._of_hand, self._take = self.hand.hand, self._of_hand.hand, take

    def sense(self, acts: bool) -> DeviceSample:
        """Return the sample at the start of a tick; the hand, on the device, acts or waits."""
        hand = self.hand
        for target in self._take() if self._take else ():
            wanted = math.nan if target is None else target
            hand = remote_target(hand, vector(wanted, self._axes))
        self.hand, self._f_h = self._hand_force(hand, self.s.x, self.s.xd, acts, self._of_hand)
        self.sample.f_h = value(self._f_h)
        return self.sample

    def step(self, f_m: Value) -> DeviceSample:
        """Advance one tick with both forces held; return the sample at its end."""
        f, sample = vector(f_m, self._axes), self.sample
        self.s, x, xd = self._device_step(self.s, self._f_h, f, self._p)
        sample.x, sample.xd = value(x), value(xd)
        sample.work = self.s.against_j, self.s.by_hand_j
        return sample
