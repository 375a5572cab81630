# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session stepped with its packets, and what it leaves behind."""

import gc
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from pmwvc_core.frame.rows import ServerRow
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.changes import over_time
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.buffers import ServerBuffer, UserBuffer, add_faults, add_learned
from pmwvc_core.simulation.conditions import FROM_SCENARIO, Conditions
from pmwvc_core.simulation.network_traces import add_network, taken_traces
from pmwvc_core.simulation.ticks import Frame
from pmwvc_core.simulation.virtual_time import NEVER_NS, VirtualTime
from pmwvc_core.traces import SessionTraces, TakenTraces

PROGRESS_NS = 1_000_000_000  # of virtual time between two reports


class SteppedSession:
    """A scenario in virtual time, stepped packet by packet."""

    def __init__(self, scenario: Scenario, conditions: Conditions = FROM_SCENARIO) -> None:
        self.tick_s, self._dof = scenario.tick_s, scenario.dof
        self.ticks = ticks = round(scenario.duration_s / self.tick_s)
        self._prescribed = bool(conditions.steps or conditions.schedule.server_s)
        self._changes = over_time(scenario)
        self.time = time = VirtualTime(
            scenario,
            ticks=ticks,
            conditions=conditions,
            on_frame=self._note,
            on_step=self._note_step,
        )
        self.tick_ns, self.server, self.users = time.tick_ns, time.server, time.users
        stages = [scenario, *(new for _, new in self._changes)]
        names = [user.name for user in scenario.users]
        self.user_buffers = [
            UserBuffer(
                name,
                ticks=ticks,
                blocks=_most(ticks, [stage.users[i].master.rate_drop for stage in stages]),
                dof=scenario.dof,
            )
            for i, name in enumerate(names)
        ]
        steps = _most(ticks, [stage.period_ticks for stage in stages])
        if conditions.steps is not None:
            steps = len(conditions.steps.tick)
        self.server_buffer = ServerBuffer(names, steps=steps, dof=scenario.dof)

    def run(self, progress: Callable[[float], None]) -> None:
        """Step to the end; ``progress`` is called with the ratio done, 0..1."""
        end_ns, changes = self.ticks * self.tick_ns, deque(self._changes)
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
        user, buffer = self.users[index], self.user_buffers[index]
        buffer.write_ticks(frame)
        if frame.ends is not None:
            loop = user.loop
            work = user.device.s.against_j, user.device.s.by_hand_j
            buffer.write_block(frame.ends, loop.report(), work, changes=loop.changes)

    def _note_step(self, tick: int, now_ns: int, row: ServerRow) -> None:
        server = self.server
        self.server_buffer.write(tick, now_ns, server.period_s, row, changes=server.changes)

    def traces(self) -> SessionTraces:
        """Return what the session leaves behind."""
        server = self.server_buffer
        traces = SessionTraces(
            source="simulated",
            duration_s=self.ticks * self.tick_s,
            users=[
                buffer.traces(
                    first=user.ticks.first,
                    tick_s=self.tick_s,
                    safety_events=user.loop.safety_events,
                )
                for user, buffer in zip(self.users, self.user_buffers, strict=True)
            ],
            server=server.traces(time_s=self._began_s(), tick_ns=self.tick_ns),
        )
        if self._prescribed:
            late_ns = np.array(server.ran_ns) - np.array(server.ticks) * self.tick_ns
            traces.metadata["server_lateness_s"] = late_ns.astype(np.float64) * 1e-9
        add_faults(traces, self.server)
        for i, user in enumerate(traces.users):
            add_learned(traces, user.name, float(np.max(self.server.learned(i) or 0.0)))
        add_network(traces, self.users, self.server, dof=self._dof)
        traces.taken = self._taken()
        return traces

    def _began_s(self) -> Array:
        """Return when steps began [s]."""
        ticks, periods_s = self.server_buffer.ticks, self.server_buffer.periods_s
        if self._prescribed or len(set(periods_s)) > 1:
            return np.array(ticks, dtype=np.float64) * self.tick_s
        return np.asarray(np.arange(len(ticks)) * np.array(periods_s))

    def _taken(self) -> dict[str, TakenTraces]:
        """Return what receivers were given."""
        return {
            f"{user.settings.name}/{way}": taken_traces(link, looks)
            for user, buffer in zip(self.users, self.user_buffers, strict=True)
            for way, link, looks in (
                ("up", user.up, self.server_buffer.ran_ns),
                ("down", user.down, buffer.times_ns),
            )
        }


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


def _most(ticks: int, lengths: list[int]) -> int:
    """Return how many frames or steps a session has at most, if their length changes."""
    return ticks // min(lengths) + 1 + len(lengths)
