# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of the frame protocol in virtual time.

Users meet at the server only: each runs by itself up to the server's next step. There all masters
send that start a frame at that instant, the server steps, then come the ticks: on their grids, or
where the loops of a recorded session ran.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.frame.rows import Frame, ServerRow
from pmwvc_core.params import ServerParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import FROM_SCENARIO, Conditions
from pmwvc_core.simulation.user import SimulatedUser

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
        self._steps: Iterator[Step] = recorded.in_order() if recorded else self._on_grid(ticks)
        self._recorded, self._due = recorded is not None, -1  # tick of the next step
        self._tick, self._at_ns, self._lasts_s = next(self._steps, NO_STEP)

    def run(self, before_ns: int) -> None:
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
