# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user in virtual time: device, hand, force loop, and the links both ways."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from pmwvc_core.frame.assembly import force_loop_of
from pmwvc_core.frame.device_sample import DeviceSample
from pmwvc_core.network.link import stream_of
from pmwvc_core.numeric import Value
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.operators import Operator, make_operator
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.event_schedule import LoopTimes
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.transport.receiver import Receiver


class SimulatedUser:
    """One user in the simulator.

    Parameters
    ----------
    index
        Number of the user, from 0.
    conditions
        Whatever does not come from the scenario.
    rates
        Rate drops that come later: tick of the session from which each holds, with the next frame.
    """

    def __init__(
        self,
        scenario: Scenario,
        index: int,
        *,
        runs: int,
        server_inbox: Receiver,
        conditions: Conditions,
        rates: Sequence[tuple[int, int]] = (),
    ) -> None:
        user, dof, tick_s = scenario.users[index], scenario.dof, scenario.tick_s
        self.settings = user
        self.loop = force_loop_of(scenario, index, schedule=conditions.schedule)
        self.times = LoopTimes(
            user.master.rate_drop,
            first=conditions.first.get(user.name, 0),
            answer=self.loop.answer_tick,
            changes=rates,
            ran_ns=conditions.ran_ns.get(user.name),
        )
        # As live: packets come in at every tick, and the hand begins the tick after an answer.
        self._live = conditions.schedule.answer_s > 0.0
        self._listens = self._live or scenario.strict
        self._acts = False
        self.up, self.down = (
            SimulatedLink(
                recorded() if recorded else params,
                seed=stream_of(scenario.seed, index, way),
                inbox=inbox,
                dof=dof,
                direction=way,
            )
            for way, (params, inbox, recorded) in enumerate(
                (
                    (user.link_up, server_inbox, conditions.links.get(f"{user.name}/up")),
                    (user.link_down, self.loop.inbox, conditions.links.get(f"{user.name}/down")),
                )
            )
        )
        half = scenario.server.object_size_m / 2
        start = user.side * (half + user.contact.gap_m)
        self.device = SimulatedDevice(user.device, tick_s=tick_s, dof=dof)
        # In a batch every run has a place of its own from the beginning.
        self.device.place(start + np.zeros((runs, 1)) if runs > 1 else start)
        hand = conditions.hands.get(user.name)
        self.operator: Operator = (
            hand()
            if hand
            else make_operator(
                user.operator,
                scenario.task,
                side=user.side,
                half_width=half,
                tick_s=tick_s,
                dof=dof,
                start=start,
            )
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

    def send(self, tick: int, now_ns: int) -> None:
        """Send the packet of a frame start."""
        packet = self.loop.start_frame(tick - self.times.first, now_ns, self._sample)
        if packet is not None:
            self.up.send(packet, now_ns)

    def advance(self, ticks: Sequence[int], times_ns: Sequence[int]) -> list[Value]:
        """Run the ticks between two events of the network.

        Returns
        -------
        list
            Signals tick by tick, in the order of ``SIGNALS``.
        """
        device, operator, sample, loop = self.device, self.operator, self._sample, self.loop
        first, acts = self.times.first, self._acts
        numbers = [tick - first for tick in ticks] if first else ticks
        packets: Sequence[WavePacket] = ()
        comes = False
        if self._listens:
            due_ns = self.down.link.next_due_ns
            comes = due_ns is not None and due_ns <= times_ns[-1]
        elif loop.takes_answer(numbers[0]):
            packets = self.down.collect(times_ns[0])
        values: list[Value] = []
        for number, now_ns in zip(numbers, times_ns, strict=True):
            if not acts:
                acts = loop.coupled or (loop.ready and not self._live)
            # The hand is in touch with the device itself, not with its encoder.
            sample.f_h = f_h = operator.step(device.x, device.xd) if acts else operator.hold()
            if comes:
                packets = self.down.collect(now_ns)
            f, _, row = loop.tick(number, now_ns, sample, packets)
            packets = ()
            sample.x, sample.xd = device.step(f_h, f)
            values += row
        self.f_applied, self._acts = f, acts or loop.coupled
        return values

    def pass_by(self) -> None:
        """Let a tick pass that the force loop missed: the last force stays on the device."""
        device, operator = self.device, self.operator
        f_h = operator.step(device.x, device.xd) if self._acts else operator.hold()
        self._sample.x, self._sample.xd = device.step(f_h, self.f_applied)
