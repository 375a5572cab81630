# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user in virtual time: device, hand, force loop, and the links both ways."""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from pmwvc_core.ends.assembly import user_end_of
from pmwvc_core.ends.simulated_device import CATCH_UP_S, SimulatedDevice
from pmwvc_core.frame.rows import Frame
from pmwvc_core.network.link import stream_of
from pmwvc_core.numeric import Integers, Value
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.conditions import Conditions, place_of
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.transport.receiver import Receiver


class Ticks:
    """The ticks of a user's loop, counted by the session, of which there are so many.

    Attributes
    ----------
    first
        Tick of the session at which the loop counts 0.
    at_ns
        Time of every tick of the session up to the last that runs.
    next
        The next tick that runs or passes.
    """

    def __init__(self, first: int, ran_ns: Integers | None, ticks: int, tick_ns: int) -> None:
        self.first = self.next = first
        self.at_ns: Sequence[int] = range(0, ticks * tick_ns, tick_ns)
        self._missed: frozenset[int] = frozenset()  # in between; they pass when it runs again
        if ran_ns is not None:
            ran = np.flatnonzero(ran_ns[:ticks] >= 0)
            ran = ran[ran >= first]
            every = np.arange(ran[-1] + 1 if len(ran) else 0)
            self.next = int(ran[0]) if len(ran) else 0
            self.at_ns = ran_ns[ran[np.searchsorted(ran, every)]].tolist()
            self._missed = frozenset(np.setdiff1d(every[self.next :], ran).tolist())
        self._ran = self.next - 1  # the last tick that ran

    def are_due(self, until_ns: int) -> bool:
        """Tell whether a tick is due by an instant [ns]."""
        return self.next < len(self.at_ns) and self.at_ns[self.next] <= until_ns

    def passing(self, most: int) -> Iterator[int]:
        """Pass what was missed; yield the ticks before ``most`` after the last one that ran."""
        while self.next in self._missed:
            if self.next < self._ran + most:
                yield self.next
            self.next += 1

    def take(self, before_ns: int, ends: int) -> tuple[range, bool]:
        """Take the ticks before an instant [ns] of a frame that ends with tick ``ends``; return
        them, and whether they are the last of it.
        """
        begin, ends = self.next, min(ends, len(self.at_ns))
        after = bisect_left(self.at_ns, before_ns, begin, ends)
        if self._missed:
            after = next((k for k in range(begin, after) if k in self._missed), after)
        self._ran, following = after - 1, after
        while following in self._missed:
            following += 1
        self.next = after
        return range(begin, after), following >= ends


class SimulatedUser:
    """The user with a number (from 0), in a session of so many ticks, with its server's inbox."""

    def __init__(
        self,
        scenario: Scenario,
        index: int,
        *,
        ticks: int,
        inbox: Receiver,
        conditions: Conditions,
    ) -> None:
        self.settings = user = scenario.users[index]
        self.loop: Any = user_end_of(scenario, index, schedule=conditions.schedule)
        inboxes, links = (inbox, self.loop.inbox), (user.link_up, user.link_down)
        self.up, self.down = (
            SimulatedLink(
                made() if (made := conditions.links.get(f"{user.name}/{way}")) else links[k],
                seed=stream_of(scenario.seed, index, k),
                inbox=inboxes[k],
                dof=scenario.dof,
                direction=k,
            )
            for k, way in enumerate(("up", "down"))
        )
        at, name = place_of(user, scenario), user.name
        hand = conditions.hands.get(name) or make_hand(user.operator, scenario.task, at)
        self.device = SimulatedDevice(user.device, hand, at.start, tick_s=at.tick_s)
        first, ran_ns = conditions.first.get(name, 0), conditions.ran_ns.get(name)
        self.ticks = Ticks(first, ran_ns, ticks, round(scenario.tick_s * 1e9))
        self._catch_up = max(1, round(CATCH_UP_S / scenario.tick_s))
        # As live: the hand begins the tick after an answer.
        self._live = conditions.schedule.answer_s > 0.0
        self._acts = False
        self._f: Value = 0.0  # of the last tick [N]

    def change(self, old: User, new: User) -> None:
        """Hand over the groups of parameters that differ to the loop and the links."""
        if new.master is not old.master:
            self.loop.hand_over(partial(self.loop.configure, new.master))
        if new.safety is not old.safety:
            self.loop.hand_over(partial(self.loop.configure_safety, new.safety))
        if new.link_up is not old.link_up:
            self.up.configure(new.link_up)
        if new.link_down is not old.link_down:
            self.down.configure(new.link_down)

    def send(self, until_ns: int) -> bool:
        """Send the packet of a frame that starts by an instant [ns]; tell whether a tick is due by
        then.
        """
        ticks = self.ticks
        if not ticks.are_due(until_ns):
            return False
        for _ in ticks.passing(self._catch_up):
            self.device.sense(self._acts)
            self.device.step(self._f)
        now_ns = ticks.at_ns[ticks.next]
        packet = self.loop.start_frame(ticks.next - ticks.first, now_ns, self.device.sample)
        if packet is not None:
            self.up.send(packet, now_ns)
        return True

    def run(self, before_ns: int) -> Iterator[Frame]:
        """Run the ticks that are due before an instant [ns], frame by frame."""
        while self.send(before_ns - 1):
            ends = self.ticks.first + self.loop.next_frame
            ticks, over = self.ticks.take(before_ns, ends)
            times_ns = self.ticks.at_ns[ticks.start : ticks.stop]
            yield Frame(ticks, times_ns, self._advance(ticks, times_ns), ends if over else None)

    def _advance(self, ticks: range, times_ns: Sequence[int]) -> list[Value]:
        """Run ticks of one frame; return their signals."""
        device, loop = self.device, self.loop
        first, acts = self.ticks.first, self._acts
        numbers = range(ticks.start - first, ticks.stop - first)
        packets: Sequence[WavePacket] = ()
        due_ns = self.down.link.next_due_ns
        values: list[Value] = []
        for number, now_ns in zip(numbers, times_ns, strict=True):
            if not acts:
                acts = loop.coupled or (loop.ready and not self._live)
            sample = device.sense(acts)
            if due_ns is not None and due_ns <= now_ns:
                packets = self.down.collect(now_ns)
                due_ns = self.down.link.next_due_ns
            f, _, row = loop.tick(number, now_ns, sample, packets)
            packets = ()
            device.step(f)
            values += row
        self._f, self._acts = f, acts or loop.coupled
        return values
