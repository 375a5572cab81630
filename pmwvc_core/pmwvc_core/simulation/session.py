# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session in virtual time: the frame protocol of the live nodes, driven by an event schedule.

With the schedule of a scenario (:data:`pmwvc_core.frame.schedule.AT_ONCE`) frame start, server
step and answer are one instant: without delay a packet arrives when it was sent.
:mod:`pmwvc_core.simulation.conditions` can give other phases.

Deterministic: the same scenario gives the same bits. Batched: scenarios of equal structure are
stepped together on arrays ``(runs, dof)``; a single run with one axis is stepped on floats, as the
live loop is.
"""

from collections import deque
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from pmwvc_core.frame.assembly import server_step_of
from pmwvc_core.frame.schedule import next_on_grid
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.changes import over_time
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.buffers import ServerBuffer, UserBuffer, add_faults
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.event_schedule import EventKind, Steps, events, first_tick, groups
from pmwvc_core.simulation.garbage import no_garbage
from pmwvc_core.simulation.network_traces import NetworkTraces
from pmwvc_core.simulation.stacking import batches, stack_scenarios
from pmwvc_core.simulation.user import SimulatedUser
from pmwvc_core.traces import SessionTraces

R = TypeVar("R")
LARGEST_BATCH = 512  # bounds the memory of the traces: 330 MB per user and ten seconds
FROM_SCENARIO = Conditions()
PROGRESS_NS = 1_000_000_000  # of virtual time between two reports


def simulate_one(scenario: Scenario, conditions: Conditions = FROM_SCENARIO) -> SessionTraces:
    """Simulate one scenario."""
    return simulate([scenario], conditions=conditions)[0]


def simulate(
    scenarios: Sequence[Scenario],
    *,
    keep: Callable[[SessionTraces], R] | None = None,
    progress: Callable[[float], None] | None = None,
    conditions: Conditions = FROM_SCENARIO,
) -> list[R] | list[SessionTraces]:
    """Simulate scenarios, those of equal structure side by side.

    Parameters
    ----------
    scenarios
        Run in batches; results come in the same order.
    keep
        Reduces the traces of each run (to its verdict, for example); all traces by default.
    progress
        Called with the ratio done, 0..1.
    conditions
        Conditions that the scenarios do not name; the same for all.
    """
    results: list[Any] = [None] * len(scenarios)
    done = 0
    for members in batches(scenarios, largest=LARGEST_BATCH):
        batch = SessionBatch([scenarios[i] for i in members], conditions)

        def report(ratio: float, *, before: int = done, size: int = len(members)) -> None:
            if progress is not None:
                progress((before + ratio * size) / len(scenarios))

        batch.run(report)
        for run, position in enumerate(members):
            traces = batch.traces(run)
            results[position] = traces if keep is None else keep(traces)
        done += len(members)
        del batch  # before the next one takes as much memory
    return results


class SessionBatch:
    """Scenarios of equal structure, stepped together."""

    def __init__(
        self, scenarios: Sequence[Scenario], conditions: Conditions = FROM_SCENARIO
    ) -> None:
        self.scenarios = list(scenarios)
        self.conditions = conditions
        scenario, runs = stack_scenarios(scenarios), len(scenarios)
        tick_s, dof = scenario.tick_s, scenario.dof
        self.tick_s, self.tick_ns = tick_s, round(tick_s * 1e9)
        self.ticks = round(scenario.duration_s / tick_s)
        changes = over_time(scenario)
        self.server = server_step_of(scenario)
        self.users = [
            SimulatedUser(
                scenario,
                i,
                runs=runs,
                server_inbox=inbox,
                conditions=conditions,
                rates=[
                    (first_tick(change.time_s, self.tick_ns), new.users[i].master.rate_drop)
                    for change, new in changes
                ],
            )
            for i, inbox in enumerate(self.server.inboxes)
        ]
        self.steps = conditions.steps or Steps.on_grid(
            every=scenario.period_ticks,
            first=self._phase(scenario),
            ticks=self.ticks,
            tick_ns=self.tick_ns,
            changes=[
                (first_tick(change.time_s, self.tick_ns), new.period_ticks, self._phase(new))
                for change, new in changes
            ],
        )
        self.server_buffer = ServerBuffer(
            [user.name for user in scenario.users],
            steps=len(self.steps.tick),
            runs=runs,
            dof=dof,
        )
        self._changes = deque(changes)
        self._present = scenario
        self._step = 0  # number of the server's step, from 0
        self._periods_s: list[float] = []
        self.user_buffers = [
            UserBuffer(user.settings.name, user.times, ticks=self.ticks, runs=runs, dof=dof)
            for user in self.users
        ]

    def run(self, progress: Callable[[float], None]) -> None:
        """Step from the first tick to the last."""
        loops = [user.times for user in self.users]
        end_ns, next_ns = self.ticks * self.tick_ns, 0
        handlers: dict[int, Callable[[int, list[int], list[int]], None]] = {
            EventKind.PASS: self._pass,
            EventKind.SEND: self._send,
            EventKind.SERVE: self._serve,
            EventKind.TICK: self._advance,
        }
        table = events(loops, self.steps, ticks=self.ticks, tick_ns=self.tick_ns)
        with no_garbage():
            for kind, who, time_ns, tick in groups(table):
                while self._changes and self._changes[0][0].time_s * 1e9 <= time_ns[0]:
                    self._change(self._changes.popleft()[1])
                handlers[kind](who, time_ns, tick)
                if time_ns[0] >= next_ns:
                    next_ns += PROGRESS_NS
                    progress(min(time_ns[0] / end_ns, 1.0))
        for user in self.users:
            user.up.drain(end_ns)
            user.down.drain(end_ns)
        progress(1.0)

    def _change(self, new: Scenario) -> None:
        """Hand over what another scenario has; groups without a change are the same objects."""
        old, self._present = self._present, new
        server = self.server
        if new.server is not old.server:
            server.hand_over(partial(self._configure_server, new))
        for index, (user, one, other) in enumerate(
            zip(self.users, old.users, new.users, strict=True)
        ):
            user.change(one, other)
            if other.contact is not one.contact:
                port = index, other.contact, other.server_impedance
                server.hand_over(partial(server.configure_user, *port))

    def _phase(self, scenario: Scenario) -> int:
        """Return the tick of its period at which the server of a scenario steps."""
        schedule, every = self.conditions.schedule, scenario.period_ticks
        return schedule.server_tick(tick_s=self.tick_s, period_ticks=every)

    def _configure_server(self, new: Scenario) -> None:
        """Give the server other parameters in a step; it ends where the next one begins."""
        tick = int(self.steps.tick[self._step])
        ends = next_on_grid(tick, new.period_ticks, self._phase(new))
        self.server.configure(new.server, first_s=(ends - tick) * self.tick_s)

    def _send(self, who: int, time_ns: list[int], tick: list[int]) -> None:
        self.users[who].send(tick[0], time_ns[0])

    def _pass(self, who: int, time_ns: list[int], tick: list[int]) -> None:
        self.users[who].pass_by()

    def _advance(self, who: int, time_ns: list[int], tick: list[int]) -> None:
        """Run ticks of a user; write energies and safety where a frame ends."""
        user, buffer = self.users[who], self.user_buffers[who]
        buffer.write_ticks(tick, user.advance(tick, time_ns))
        if buffer.ends_block(tick[-1]):
            buffer.write_block(user.loop.report(), user.device.work)

    def _serve(self, who: int, time_ns: list[int], tick: list[int]) -> None:
        """Step the server on what has arrived; send its answers."""
        now_ns, self._step = time_ns[0], tick[0]
        answers, row = self.server.tick(now_ns, [user.up.collect(now_ns) for user in self.users])
        for user, answer in zip(self.users, answers, strict=True):
            if answer is not None:
                user.down.send(answer, now_ns)
        if row is not None:
            self.server_buffer.write(tick[0], row)
            self._periods_s.append(self.server.period_s)

    def traces(self, run: int) -> SessionTraces:
        """Return what one run of the batch leaves behind."""
        traces = SessionTraces(
            source="simulated",
            duration_s=self.ticks * self.tick_s,
            users=[
                buffer.run(
                    run,
                    tick_s=self.tick_s,
                    safety_events=_of_run(user.loop.safety.events, run),
                )
                for user, buffer in zip(self.users, self.user_buffers, strict=True)
            ],
            server=self.server_buffer.run(run, **self._server_times),
        )
        if self._prescribed:
            late_ns = self.steps.ran_ns - self.steps.tick * self.tick_ns
            traces.metadata["server_lateness_s"] = late_ns.astype(np.float64) * 1e-9
        add_faults(traces, self.server)
        self._network.add_to(traces, run)
        return traces

    @property
    def _prescribed(self) -> bool:
        """Whether steps run at other times than from the first tick on, evenly."""
        return bool(self.conditions.steps or self.conditions.schedule.server_s)

    @property
    def _server_times(self) -> dict[str, Array]:
        """When steps began and how long they lasted [s]."""
        periods_s = np.array(self._periods_s, dtype=np.float64)
        if self._prescribed or len(set(self._periods_s)) > 1:
            time_s = self.steps.tick.astype(np.float64) * self.tick_s
        else:
            time_s = np.arange(len(periods_s), dtype=np.float64) * periods_s
        return {"time_s": time_s, "periods_s": periods_s}

    @cached_property
    def _network(self) -> NetworkTraces:
        runs, dof = len(self.scenarios), self.scenarios[0].dof
        return NetworkTraces(self.users, self.server, runs=runs, dof=dof)


def _of_run(value: object, run: int) -> int:
    """Return one run's entry of a count that a batch may hold as an array."""
    return int(value[run, 0]) if isinstance(value, np.ndarray) else int(value)  # type: ignore[call-overload]
