# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in virtual time: the frame protocol of the live nodes, as fast as the machine can.
Deterministic: the same scenario gives the same bits; compiled, for many sessions
(:mod:`.bulk.run`), the same numbers to rounding.
"""

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from pmwvc_core.frame import Frame, ServerRow
from pmwvc_core.plant.forces import task_of
from pmwvc_core.scenario.names import over_time
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.server.black_box import description_of
from pmwvc_core.simulation.bulk.loop import note_step
from pmwvc_core.simulation.bulk.run import empty_steps, loops_of, run
from pmwvc_core.simulation.conditions import FROM_SCENARIO, Conditions, add_link
from pmwvc_core.simulation.traces import Step, UserNotes, learned_events, stepped_server, traces_of
from pmwvc_core.simulation.virtual_time import NEVER_NS, VirtualTime
from pmwvc_core.traces import SessionTraces

PROGRESS_NS = 1_000_000_000  # of virtual time between two reports
R = TypeVar("R")


class SteppedSession(VirtualTime):
    """A scenario in virtual time, stepped packet by packet from its start to its end."""

    def __init__(self, scenario: Scenario, conditions: Conditions = FROM_SCENARIO) -> None:
        self._scenario, self.tick_s = scenario, scenario.tick_s
        self.ticks = round(scenario.duration_s / self.tick_s)
        observers: dict[str, Any] = {"on_frame": self._note, "on_step": self._note_step}
        super().__init__(scenario, ticks=self.ticks, conditions=conditions, **observers)
        self._prescribed = bool(conditions.steps or conditions.schedule.server_s)
        self._task = task_of(scenario.task, scenario.dof)
        self.user_notes = [UserNotes(scenario.dof) for _ in scenario.users]
        self.steps: list[Step] = []

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

    def _note(self, index: int, frame: Frame) -> None:
        """Note ticks of a user; energies and safety where a frame ends."""
        user, notes = self.users[index], self.user_notes[index]
        notes.write(frame)
        if frame.ends is not None:
            work = user.device.s.against_j, user.device.s.by_hand_j
            notes.frames.append((frame.ends, user.loop.report(), work, user.loop.changes))

    def _note_step(self, tick: int, now_ns: int, row: ServerRow) -> None:
        server, arrays = self.server, empty_steps(self._scenario, 1)
        note_step(server.s, 0, server.p, self._task, *arrays)
        of_step = tick, now_ns, server.p.period_s, server.changes, arrays
        self.steps.append(Step(*of_step, row.poses, row.contacts, row.contained))

    def traces(self) -> SessionTraces:
        """Return what the session leaves behind."""
        faults, looks_ns = self.server.faults, [step.ran_ns for step in self.steps]
        traces = SessionTraces("simulated", self.ticks * self.tick_s, [], None)
        for user, own in zip(self.users, self.user_notes, strict=True):
            name = user.settings.name
            of: dict[str, Any] = {"ticks": self.ticks, "tick_s": self.tick_s}
            of |= {"first": user.ticks.first, "events": user.loop.s.limits.events}
            traces.users.append(own.traces(name, **of))
            for way, link, looks, end in (
                ("up", user.up, looks_ns, self.server),
                ("down", user.down, own.times_ns, user.loop),
            ):
                add_link(traces, name, way, *link.traces(looks, end.other_controller))
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
    scenarios: Sequence[Scenario], *, keep: Callable[[SessionTraces, Scenario], R] | None = None,
    progress: Callable[[float], None] | None = None, conditions: Conditions = FROM_SCENARIO,
) -> list[R] | list[SessionTraces]:  # fmt: skip
    """Simulate scenarios under the same conditions, many of a kind compiled; results come in
    order. ``keep`` reduces the traces of each run, with its scenario; ``progress`` gets the ratio
    done, 0..1.
    """
    results: list[Any] = []
    alone = len(scenarios) == 1 or conditions is not FROM_SCENARIO
    loops = [None] * len(scenarios) if alone else loops_of(scenarios)
    for done, (scenario, loop) in enumerate(zip(scenarios, loops, strict=True)):

        def report(ratio: float, *, before: int = done) -> None:
            if progress is not None:
                progress((before + ratio) / len(scenarios))

        left = run(scenario, loop) if loop is not None else None
        if left is not None and left.whole:
            traces = traces_of(left)
        else:  # also where a wave did not go by the plan of the network
            traces = simulate_one(scenario, conditions, progress=report)
        report(1.0)
        results.append(traces if keep is None else keep(traces, scenario))
    return results
