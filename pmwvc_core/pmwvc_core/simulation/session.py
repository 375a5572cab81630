# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in virtual time: the frame protocol of the live nodes, as fast as the machine can.

With the schedule of a scenario (:data:`pmwvc_core.frame.schedule.AT_ONCE`) frame start, server
step and answer are one instant: without delay a packet arrives when it was sent.
:mod:`pmwvc_core.simulation.conditions` can give other phases.

Deterministic: the same scenario gives the same bits; compiled, for many sessions
(:mod:`.bulk.choice`), the same numbers to rounding.
"""

import gc
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

import numpy as np

from pmwvc_core.frame.rows import Frame, ServerRow
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.changes import over_time
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.bulk.choice import loops_of
from pmwvc_core.simulation.bulk.run import run
from pmwvc_core.simulation.bulk.traces import learned_events, traces_of
from pmwvc_core.simulation.conditions import FROM_SCENARIO, Conditions
from pmwvc_core.simulation.notes import ServerNotes, UserNotes
from pmwvc_core.simulation.virtual_time import NEVER_NS, VirtualTime
from pmwvc_core.traces import SessionTraces

PROGRESS_NS = 1_000_000_000  # of virtual time between two reports
R = TypeVar("R")


class SteppedSession:
    """A scenario in virtual time, stepped packet by packet."""

    def __init__(self, scenario: Scenario, conditions: Conditions = FROM_SCENARIO) -> None:
        self._scenario, self.tick_s = scenario, scenario.tick_s
        self.ticks = round(scenario.duration_s / self.tick_s)
        self._prescribed = bool(conditions.steps or conditions.schedule.server_s)
        self.time = time = VirtualTime(
            scenario,
            ticks=self.ticks,
            conditions=conditions,
            on_frame=self._note,
            on_step=self._note_step,
        )
        self.tick_ns, self.server, self.users = time.tick_ns, time.server, time.users
        self.user_notes = [UserNotes(scenario.dof) for _ in scenario.users]
        self.server_notes = ServerNotes(scenario.dof)

    def run(self, progress: Callable[[float], None]) -> None:
        """Step to the end; ``progress`` is called with the ratio done, 0..1."""
        end_ns, changes = self.ticks * self.tick_ns, deque(over_time(self._scenario))
        with _no_garbage():
            for begin_ns in range(0, end_ns, PROGRESS_NS):
                progress(begin_ns / end_ns)
                until_ns = min(begin_ns + PROGRESS_NS, end_ns)
                while changes and changes[0][0].time_s * 1e9 < until_ns:
                    change, new = changes.popleft()
                    self.time.run(round(change.time_s * 1e9))
                    self.time.change(new)
                self.time.run(until_ns)
            self.time.run(NEVER_NS)  # ticks and steps that a recording has later than due
        for user in self.users:
            user.up.drain(end_ns)
            user.down.drain(end_ns)
        progress(1.0)

    def _note(self, index: int, frame: Frame) -> None:
        """Note ticks of a user; energies and safety where a frame ends."""
        user, notes = self.users[index], self.user_notes[index]
        notes.write_ticks(frame)
        if frame.ends is not None:
            work = user.device.s.against_j, user.device.s.by_hand_j
            notes.write_block(frame.ends, user.loop.report(), work, changes=user.loop.changes)

    def _note_step(self, tick: int, now_ns: int, row: ServerRow) -> None:
        server = self.server
        self.server_notes.write(tick, now_ns, server.period_s, row, changes=server.changes)

    def traces(self) -> SessionTraces:
        """Return what the session leaves behind."""
        names, notes, faults = [], self.server_notes, self.server.faults
        traces = SessionTraces("simulated", self.ticks * self.tick_s, [], None)
        for user, own in zip(self.users, self.user_notes, strict=True):
            name, loop = user.settings.name, user.loop
            names.append(name)
            of: dict[str, Any] = {"ticks": self.ticks, "tick_s": self.tick_s}
            of |= {"first": user.ticks.first, "events": loop.safety_events}
            traces.users.append(own.traces(name, **of))
            for way, link, sender, receiver, end, looks_ns in (
                ("up", user.up, f"/{name}", f"/server/{name}", self.server, notes.ran_ns),
                ("down", user.down, f"/server/{name}", f"/{name}", loop, own.times_ns),
            ):
                which, other = f"{name}/{way}", end.other_controller
                for seen in link.packet_traces(f"{sender}/wave_{way}", f"{receiver}/wave_{way}"):
                    traces.packets[seen.topic] = seen
                    traces.counts[seen.topic] = {"messages": len(seen.seq), "missing": 0}
                traces.fates[which] = link.fate_traces(which)
                traces.receptions[which] = link.reception(which, other_controller=other)
                traces.taken[which] = link.taken_traces(looks_ns)
                if link.link.faults.count:  # of plug-ins
                    traces.metadata.setdefault("links", {})[which] = str(link.link.faults)
        traces.server = notes.traces(names, time_s=self._began_s(), tick_ns=self.tick_ns)
        if self._prescribed:
            traces.metadata["server_lateness_s"] = traces.server.looked_ns * 1e-9
        if faults.steps and faults.replaced:
            contained = {"contained_steps": str(faults.steps), "last_fault": faults.text}
            traces.metadata[faults.what] = contained
        elif faults.steps:
            what = f"{faults.steps} steps: {faults.text}"
            event = {"time_s": None, "who": "server", "kind": "environment", "what": what}
            traces.events.append(event)
        learned = [float(np.max(self.server.learned(i) or 0.0)) for i in range(len(names))]
        traces.events += learned_events(names, learned)
        return traces

    def _began_s(self) -> Array:
        """Return when steps began [s]."""
        ticks, periods_s = self.server_notes.ticks, self.server_notes.periods_s
        if self._prescribed or len(set(periods_s)) > 1:
            return np.array(ticks, dtype=np.float64) * self.tick_s
        return np.asarray(np.arange(len(ticks)) * np.array(periods_s))


@contextmanager
def _no_garbage() -> Iterator[None]:
    """Disable the cyclic garbage collector inside the context; restore its state at the end.

    The objects that a session keeps (packets, fates, waiting numbers) hold no reference cycles,
    and scanning their growing number takes a twentieth of the time.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def simulate_one(scenario: Scenario, conditions: Conditions = FROM_SCENARIO) -> SessionTraces:
    """Simulate one scenario."""
    return _stepped(scenario, conditions, lambda ratio: None)


def simulate(
    scenarios: Sequence[Scenario],
    *,
    keep: Callable[[SessionTraces, Scenario], R] | None = None,
    progress: Callable[[float], None] | None = None,
    conditions: Conditions = FROM_SCENARIO,
) -> list[R] | list[SessionTraces]:
    """Simulate scenarios, many of a kind compiled.

    Parameters
    ----------
    scenarios
        Results come in the same order.
    keep
        Reduces the traces of each run, with its scenario (to its verdict, for example); all traces
        by default.
    progress
        Called with the ratio done, 0..1.
    conditions
        Conditions that the scenarios do not name; the same for all.
    """
    results: list[Any] = []
    alone = len(scenarios) == 1 or conditions is not FROM_SCENARIO
    loops = [None] * len(scenarios) if alone else loops_of(scenarios)
    for done, (scenario, loop) in enumerate(zip(scenarios, loops, strict=True)):

        def report(ratio: float, *, before: int = done) -> None:
            if progress is not None:
                progress((before + ratio) / len(scenarios))

        traces = _in_bulk(scenario, loop) if loop is not None else None
        if traces is None:
            traces = _stepped(scenario, conditions, report)
        report(1.0)
        results.append(traces if keep is None else keep(traces, scenario))
    return results


def _stepped(
    scenario: Scenario, conditions: Conditions, progress: Callable[[float], None]
) -> SessionTraces:
    session = SteppedSession(scenario, conditions)
    session.run(progress)
    return session.traces()


def _in_bulk(scenario: Scenario, loop: Callable[..., bool]) -> SessionTraces | None:
    """Return the traces of a session; None where a wave did not go by the plan of the network."""
    left = run(scenario, loop)
    return traces_of(left) if left.whole else None
