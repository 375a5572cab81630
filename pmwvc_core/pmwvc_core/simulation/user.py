# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user in virtual time: device, hand, force loop, and the links both ways."""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from pmwvc_core.frame.assembly import force_loop_of
from pmwvc_core.frame.device_sample import DeviceSample
from pmwvc_core.network.link import stream_of
from pmwvc_core.numeric import Value
from pmwvc_core.plant.devices import CATCH_UP_S, SimulatedDevice
from pmwvc_core.plant.forces import Operator, Setting
from pmwvc_core.plant.operators import make_operator
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.transport.receiver import Receiver


class Frame(NamedTuple):
    """Ticks of a frame that ran, all or a part.

    Attributes
    ----------
    ticks, times_ns
        Of the session, and when they ran [ns].
    values
        Signals tick by tick, in the order of ``SIGNALS``.
    ends
        Tick with which the next frame starts; None while more of this one is to run.
    """

    ticks: Sequence[int]
    times_ns: Sequence[int]
    values: list[Value]
    ends: int | None


class SimulatedUser:
    """One user in the simulator.

    Parameters
    ----------
    index
        Number of the user, from 0.
    ticks
        Length of the session.
    inbox
        The user's receiver at the server.
    conditions
        Whatever does not come from the scenario.
    """

    def __init__(
        self,
        scenario: Scenario,
        index: int,
        *,
        ticks: int,
        runs: int,
        inbox: Receiver,
        conditions: Conditions,
    ) -> None:
        user, dof, tick_s = scenario.users[index], scenario.dof, scenario.tick_s
        self.settings = user
        self.loop = force_loop_of(scenario, index, schedule=conditions.schedule)
        times = conditions.times(user.name, ticks=ticks, tick_ns=round(tick_s * 1e9))
        self.first, self._next, self._times, self._missed = times
        self._ran = self._next - 1  # the last tick that ran
        self._catch_up = max(1, round(CATCH_UP_S / tick_s))
        # As live: packets come in at every tick, and the hand begins the tick after an answer.
        self._live = conditions.schedule.answer_s > 0.0
        self._listens = self._live or scenario.strict
        self._acts = False
        ways = (("up", user.link_up, inbox), ("down", user.link_down, self.loop.inbox))
        self.up, self.down = (
            SimulatedLink(
                conditions.links.get(f"{user.name}/{name}", lambda params=params: params)(),
                seed=stream_of(scenario.seed, index, way),
                inbox=end,
                dof=dof,
                direction=way,
            )
            for way, (name, params, end) in enumerate(ways)
        )
        half = scenario.server.object_size_m / 2
        start = user.side * (half + user.contact.gap_m)
        self.device = SimulatedDevice(user.device, tick_s=tick_s, dof=dof)
        # In a batch every run has a place of its own from the beginning.
        self.device.place(start + np.zeros((runs, 1)) if runs > 1 else start)
        hand = conditions.hands.get(user.name)
        at = Setting(user.side, half, start, tick_s, dof)
        self.operator: Operator = (
            hand() if hand else make_operator(user.operator, scenario.task, at)
        )
        self.f_applied: Value = 0.0
        self._sample = DeviceSample(*self.device.read())

    def change(self, old: User, new: User) -> None:
        """Take over what is another object than before; a recorded link stays as recorded."""
        loop = self.loop
        if new.master is not old.master:
            loop.hand_over(partial(loop.configure, new.master))
        if new.safety is not old.safety:
            loop.hand_over(partial(loop.safety.configure, new.safety))
        if new.link_up is not old.link_up:
            self.up.configure(new.link_up)
        if new.link_down is not old.link_down:
            self.down.configure(new.link_down)

    def send(self, until_ns: int) -> bool:
        """Send the packet of a frame that starts by an instant [ns]; tell whether a tick is due by
        then.
        """
        tick = self._next
        if tick >= len(self._times) or self._times[tick] > until_ns:
            return False
        while tick in self._missed:
            if tick < self._ran + self._catch_up:
                self._pass_by()
            self._next = tick = tick + 1
        now_ns = self._times[tick]
        packet = self.loop.start_frame(tick - self.first, now_ns, self._sample)
        if packet is not None:
            self.up.send(packet, now_ns)
        return True

    def run(self, before_ns: int) -> Iterator[Frame]:
        """Run the ticks that are due before an instant [ns], frame by frame."""
        times, missed = self._times, self._missed
        while self.send(before_ns - 1):
            tick, ends = self._next, self.first + self.loop.frames.next_frame
            after = bisect_left(times, before_ns, tick, min(ends, len(times)))
            if missed:
                after = next((k for k in range(tick, after) if k in missed), after)
            ticks, at = range(tick, after), times[tick:after]
            values = self._advance(ticks, at)
            self._next, self._ran = after, after - 1
            while after in missed:
                after += 1
            over = after >= min(ends, len(times))
            yield Frame(ticks, at, values, ends if over else None)

    def _advance(self, ticks: Sequence[int], times_ns: Sequence[int]) -> list[Value]:
        """Run ticks of one frame; return their signals."""
        device, operator, sample, loop = self.device, self.operator, self._sample, self.loop
        first, acts = self.first, self._acts
        numbers = [tick - first for tick in ticks] if first else ticks
        packets: Sequence[WavePacket] = ()
        due_ns = None  # when the next packet comes, where it is taken at once
        if self._listens:
            due_ns = self.down.link.next_due_ns
        elif loop.frames.answers(numbers[0]):
            packets = self.down.collect(times_ns[0])
        values: list[Value] = []
        for number, now_ns in zip(numbers, times_ns, strict=True):
            if not acts:
                acts = loop.coupled or (loop.ready and not self._live)
            # The hand is in touch with the device itself, not with its encoder.
            sample.f_h = f_h = operator.step(device.x, device.xd) if acts else operator.hold()
            if due_ns is not None and due_ns <= now_ns:
                packets = self.down.collect(now_ns)
                due_ns = self.down.link.next_due_ns
            f, _, row = loop.tick(number, now_ns, sample, packets)
            packets = ()
            sample.x, sample.xd = device.step(f_h, f)
            values += row
        self.f_applied, self._acts = f, acts or loop.coupled
        return values

    def _pass_by(self) -> None:
        """Let a tick pass that the force loop missed, at the device."""
        device, operator = self.device, self.operator
        f_h = operator.step(device.x, device.xd) if self._acts else operator.hold()
        self._sample.x, self._sample.xd = device.step(f_h, self.f_applied)
