# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in virtual time: the frame protocol of the live nodes, as fast as the machine can.
Deterministic: the same scenario gives the same bits; compiled, for many sessions
(:mod:`.bulk.run`), the same numbers to rounding.
"""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.frame import ServerRow
from pmwvc_core.params import ServerParams
from pmwvc_core.plant.forces import task_of
from pmwvc_core.scenario.names import over_time
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.server.black_box import description_of
from pmwvc_core.simulation.bulk.loop import note_step
from pmwvc_core.simulation.bulk.run import empty_steps, loops_of, run
from pmwvc_core.simulation.conditions import FROM_SCENARIO, Conditions, add_link
from pmwvc_core.simulation.traces import Step, learned_events, stepped_server, traces_of
from pmwvc_core.simulation.virtual_time import SimulatedUser
from pmwvc_core.traces import SessionTraces

PROGRESS_NS = 1_000_000_000  # of virtual time between two reports
NEVER_NS = (1 << 63) - 1
Due = tuple[int, int, float | None]  # of a step: tick, time [ns], length where given [s]
NO_STEP: Due = (0, NEVER_NS, None)


class SteppedSession:
    """A scenario in virtual time, stepped packet by packet.

    Users meet at the server only: each runs by itself up to the server's next step. There all
    masters send that start a frame at that instant, the server steps, then come the ticks.
    """

    def __init__(self, scenario: Scenario, conditions: Conditions = FROM_SCENARIO) -> None:
        self._scenario, self.tick_s = scenario, scenario.tick_s  # as it is now
        self.tick_ns = round(self.tick_s * 1e9)
        self.ticks = round(scenario.duration_s / self.tick_s)
        self.server: Any = ServerEnd(scenario)
        self.users = [
            SimulatedUser(scenario, i, self.ticks, inbox, conditions)
            for i, inbox in enumerate(self.server.inboxes)
        ]
        self._task = task_of(scenario.task, scenario.dof)
        self.steps: list[Step] = []
        recorded, schedule = conditions.steps, conditions.schedule
        self._prescribed = bool(recorded or schedule.server_s)
        self._next_step = partial(schedule.next_step, tick_s=self.tick_s)
        self._steps: Iterator[Any] = self._on_grid()
        if recorded:
            self._steps = zip(*(column.tolist() for column in recorded), strict=True)
        self._due = -1  # tick of the next step, if it runs
        self._tick, self._at_ns, self._lasts_s = next(self._steps, NO_STEP)

    def run(self, progress: Callable[[float], None]) -> None:
        """Step to the end; ``progress`` is called with the ratio done, 0..1."""
        end_ns, changes = self.ticks * self.tick_ns, deque(over_time(self._scenario))
        for begin_ns in range(0, end_ns, PROGRESS_NS):
            progress(begin_ns / end_ns)
            until_ns = min(begin_ns + PROGRESS_NS, end_ns)
            while changes and changes[0][0].time_s * 1e9 < until_ns:
                change, new = changes.popleft()
                self.advance(round(change.time_s * 1e9))
                self.change(new)
            self.advance(until_ns)
        self.advance(NEVER_NS)  # ticks and steps that a recording has later than due
        for user in self.users:
            user.up.drain(end_ns)
            user.down.drain(end_ns)
        progress(1.0)

    def _note_step(self, tick: int, now_ns: int, row: ServerRow) -> None:
        server, arrays = self.server, empty_steps(self._scenario, 1)
        note_step(server.s, 0, server.p, self._task, *arrays)
        self.steps.append(Step(tick, now_ns, server.p.period_s, server.changes, arrays, row))

    def advance(self, before_ns: int) -> None:
        """Step everything that is due before an instant [ns]."""
        while True:
            now_ns = min(self._at_ns, before_ns)
            for user in self.users:
                user.run(now_ns)
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
                self._note_step(self._tick, now_ns, row)
            self._due = self._tick + round(self.server.p.period_s * 1e9 / self.tick_ns)
            self._tick, self._at_ns, self._lasts_s = next(self._steps, NO_STEP)

    def _on_grid(self) -> Iterator[Due]:
        tick = -1
        while (tick := self._next_step(tick, period_s=self.server.params.period_s)) < self.ticks:
            yield tick, tick * self.tick_ns, None

    def change(self, new: Scenario) -> None:
        """Hand over what another scenario has."""
        old = self._scenario
        if new.server != old.server:
            self.server.hand_over(partial(self._configure, new.server))
        for index, (one, other) in enumerate(zip(old.users, new.users, strict=True)):
            self.users[index].change(one, other)
            if other.contact != one.contact:
                port = index, other.contact, other.server_impedance
                self.server.hand_over(partial(self.server.configure_user, *port))
        self._scenario = new

    def _configure(self, params: ServerParams) -> None:
        """Have the server take parameters over; this step lasts to where the next one begins."""
        ticks = self._next_step(self._tick, period_s=params.period_s) - self._tick
        lasts_s = ticks * self.tick_s if self._lasts_s is None else self._lasts_s
        self.server.configure(params, first_s=lasts_s)

    def traces(self) -> SessionTraces:
        """Return what the session leaves behind."""
        faults, looks_ns = self.server.faults, [step.ran_ns for step in self.steps]
        traces = SessionTraces("simulated", self.ticks * self.tick_s, [], None)
        for user in self.users:
            name = user.settings.name
            traces.users.append(user.traces())
            both = ("up", user.up, looks_ns), ("down", user.down, user.notes.times_ns)
            for way, link, looks in both:
                add_link(traces, name, way, *link.traces(looks))
                if link.link.failed:  # plug-ins
                    traces.metadata.setdefault("links", {})[f"{name}/{way}"] = link.link.failed
        began_s = self.tick_s * np.array([step.tick for step in self.steps], dtype=float)
        traces.server = stepped_server(self._scenario, self.steps, began_s)
        traces.server.scene = description_of(self.server.s.environment.body)
        if self._prescribed:
            traces.metadata["server_lateness_s"] = traces.server.looked_ns * 1e-9
        if faults.steps and faults.replaced:
            contained = {"contained_steps": str(faults.steps), "last_fault": faults.text}
            traces.metadata[faults.what] = contained
        elif faults.steps:
            what = {"kind": "environment", "what": f"{faults.steps} steps: {faults.text}"}
            traces.events.append({"time_s": None, "who": "server", **what})
        if self.steps:
            traces.events += learned_events(self._scenario, self.steps[-1].arrays[1])
        return traces


def simulate_one(
    scenario: Scenario, conditions: Conditions = FROM_SCENARIO, *,
    progress: Callable[[float], None] = lambda ratio: None,
) -> SessionTraces:  # fmt: skip
    """Simulate one scenario; ``progress`` is called with the ratio done, 0..1."""
    session = SteppedSession(scenario, conditions)
    session.run(progress)
    return session.traces()


def simulate(
    scenarios: Sequence[Scenario], *,
    keep: Callable[[SessionTraces, Scenario], Any] = lambda traces, _: traces,
    progress: Callable[[float], None] = lambda ratio: None,
) -> list[Any]:  # fmt: skip
    """Simulate scenarios, many of a kind compiled; results come in order. ``keep`` reduces the
    traces of each run, with its scenario; ``progress`` gets the ratio done, 0..1.
    """
    results: list[Any] = []
    loops = loops_of(scenarios) if len(scenarios) > 1 else [None for _ in scenarios]
    for done, (scenario, loop) in enumerate(zip(scenarios, loops, strict=True)):

        def report(ratio: float, *, before: int = done) -> None:
            progress((before + ratio) / len(scenarios))

        left = run(scenario, loop) if loop is not None else None
        if left is not None and left.whole:
            traces = traces_of(left)
        else:  # also where a wave did not go by the plan of the network
            traces = simulate_one(scenario, progress=report)
        report(1.0)
        results.append(keep(traces, scenario))
    return results
