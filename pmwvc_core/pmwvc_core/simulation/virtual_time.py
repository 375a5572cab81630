# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of the frame protocol in virtual time.

Users (device, hand, force loop, and the links both ways) meet at the server only: each runs by
itself up to the server's next step. There all masters send that start a frame at that instant, the
server steps, then come the ticks: on their grids, or where the loops of a recorded session ran.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.ends.user_end import CATCH_UP_S, DevicePlant, UserEnd
from pmwvc_core.frame import Frame, ServerRow
from pmwvc_core.numeric import Value
from pmwvc_core.params import ServerParams
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.conditions import FROM_SCENARIO, Conditions, Ticks, place_of
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.transport.receiver import Receiver


class SimulatedUser:
    """The user with a number (from 0), in a session of so many ticks, with its server's inbox."""

    def __init__(
        self, scenario: Scenario, index: int, ticks: int, inbox: Receiver, conditions: Conditions
    ) -> None:
        self.settings = user = scenario.users[index]
        self.loop = UserEnd(user, scenario, epoch=index + 1, schedule=conditions.schedule)
        self.up = conditions.link_of(scenario, index, 0, inbox)
        self.down = conditions.link_of(scenario, index, 1, self.loop.inbox)
        at, name = place_of(user, scenario), user.name
        hand = conditions.hands.get(name) or make_hand(user.operator, scenario.task, at)
        self.device = DevicePlant(user.device, hand, at.start, tick_s=at.tick_s)
        first, ran_ns = conditions.first.get(name, 0), conditions.ran_ns.get(name)
        self.ticks = Ticks(first, ran_ns, ticks, round(scenario.tick_s * 1e9))
        self._catch_up = max(1, round(CATCH_UP_S / scenario.tick_s))
        # As live: the hand begins the tick after an answer.
        self._live = conditions.schedule.answer_s > 0.0
        self._acts = False
        self._f: Value = 0.0  # of the last tick [N]

    def change(self, old: User, new: User) -> None:
        """Hand over the groups of parameters that differ to the loop and the links."""
        both = {n: (getattr(old, n), getattr(new, n)) for n in ("master", "given_safety")}
        if groups := {name: other for name, (one, other) in both.items() if other != one}:
            self.loop.hand_over(partial(self.loop.configure, **groups))
        if new.link_up != old.link_up:
            self.up.configure(new.link_up)
        if new.link_down != old.link_down:
            self.down.configure(new.link_down)

    def send(self, until_ns: int) -> bool:
        """Send the packet of a frame that starts by then [ns]; tell whether a tick is due."""
        ticks = self.ticks
        if not (ticks.next < len(ticks.at_ns) and ticks.at_ns[ticks.next] <= until_ns):
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
            ends = self.ticks.first + self.loop.s.next_frame
            ticks, over = self.ticks.take(before_ns, ends)
            times_ns = self.ticks.at_ns[ticks.start : ticks.stop]
            yield Frame(ticks, times_ns, self._advance(ticks, times_ns), ends if over else None)

    def _advance(self, ticks: range, times_ns: Sequence[int]) -> list[Value]:
        device, loop = self.device, self.loop
        first, acts = self.ticks.first, self._acts
        numbers = range(ticks.start - first, ticks.stop - first)
        packets: Sequence[WavePacket] = ()
        due_ns = self.down.link.next_due_ns
        values: list[Value] = []
        for number, now_ns in zip(numbers, times_ns, strict=True):
            if not acts:
                # In the soft start the hand would push the device away from its avatar.
                acts = loop.s.coupled or (loop.s.limits.ready and not self._live)
            sample = device.sense(acts)
            if due_ns is not None and due_ns <= now_ns:
                packets = self.down.collect(now_ns)
                due_ns = self.down.link.next_due_ns
            f, _, row = loop.tick(number, now_ns, sample, packets)
            packets = ()
            device.step(f)
            values += row
        self._f, self._acts = f, acts or loop.s.coupled
        return values


ENDLESS = 1 << 40  # ticks
NEVER_NS = (1 << 63) - 1
Step = tuple[int, int, float | None]  # of the server: tick, time [ns], length where given [s]
NO_STEP: Step = (0, NEVER_NS, None)


class VirtualTime:
    """The ends of a scenario, stepped as far as wanted: ``on_frame`` gets the number of a user and
    ticks that it ran, ``on_step`` tick, time [ns] and row of a step of the server.
    """

    def __init__(
        self, scenario: Scenario, *, on_frame: Callable[[int, Frame], None],
        on_step: Callable[[int, int, ServerRow], None], ticks: int = ENDLESS,
        conditions: Conditions = FROM_SCENARIO,
    ) -> None:  # fmt: skip
        self._present, self.tick_ns = scenario, round(scenario.tick_s * 1e9)
        self.server: Any = ServerEnd(scenario)
        self.users = [
            SimulatedUser(scenario, i, ticks=ticks, inbox=inbox, conditions=conditions)
            for i, inbox in enumerate(self.server.inboxes)
        ]
        self._on_frame, self._on_step = on_frame, on_step
        self._next_step = partial(conditions.schedule.next_step, tick_s=scenario.tick_s)
        recorded = conditions.steps
        self._steps: Iterator[Any] = self._on_grid(ticks)
        if recorded:
            self._steps = zip(*(column.tolist() for column in recorded), strict=True)
        self._recorded, self._due = recorded is not None, -1  # tick of the next step
        self._tick, self._at_ns, self._lasts_s = next(self._steps, NO_STEP)

    def advance(self, before_ns: int) -> None:
        """Step everything that is due before an instant [ns]."""
        while True:
            now_ns = min(self._at_ns, before_ns)
            for index, user in enumerate(self.users):
                for frame in user.run(now_ns):
                    self._on_frame(index, frame)
            if self._at_ns >= before_ns:
                return
            for user in self.users:
                user.send(now_ns)
            packets = [user.up.collect(now_ns) for user in self.users]
            missed = self._tick - self._due if 0 <= self._due < self._tick else 0
            answers, row = self.server.tick(now_ns, packets, missed * self.tick_ns * 1e-9)
            for user, answer in zip(self.users, answers, strict=True):
                if answer is not None:
                    user.down.send(answer, now_ns)
            if row is not None:
                self._on_step(self._tick, now_ns, row)
            if self._recorded:
                self._due = self._tick + round(self.server.p.period_s * 1e9 / self.tick_ns)
            self._tick, self._at_ns, self._lasts_s = next(self._steps, NO_STEP)

    def _on_grid(self, ticks: int) -> Iterator[Step]:
        tick = -1
        while (tick := self._next_step(tick, period_s=self.server.params.period_s)) < ticks:
            yield tick, tick * self.tick_ns, None

    def change(self, new: Scenario) -> None:
        """Hand over what another scenario has."""
        old = self._present
        if new.server != old.server:
            self.server.hand_over(partial(self._configure, new.server))
        for index, (one, other) in enumerate(zip(old.users, new.users, strict=True)):
            self.users[index].change(one, other)
            if other.contact != one.contact:
                port = index, other.contact, other.server_impedance
                self.server.hand_over(partial(self.server.configure_user, *port))
        self._present = new

    def _configure(self, params: ServerParams) -> None:
        """Have the server take parameters over; this step lasts to where the next one begins."""
        ticks = self._next_step(self._tick, period_s=params.period_s) - self._tick
        lasts_s = ticks * self._present.tick_s if self._lasts_s is None else self._lasts_s
        self.server.configure(params, first_s=lasts_s)
