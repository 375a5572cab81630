# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session of a page that is simulated in real time: virtual time as far as the clock says.

Unlike a simulation it has no end, and its parameters change while it runs. Needs no ROS.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pmwvc_core.ends.inbox import value
from pmwvc_core.ends.user_end import Target
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.server.black_box import description_of
from pmwvc_core.simulation.session import SteppedSession
from pmwvc_core.simulation.traces import stepped_server
from pmwvc_core.simulation.virtual_time import TickNotes
from pmwvc_view import SNAPSHOT_S, controls, description
from pmwvc_view.controls import Control, Setting, Settings
from pmwvc_view.feed.feed import Feed
from pmwvc_view.protocol.snapshot import Snapshot
from pmwvc_view.session import Handled, Session, ramped


class Simulation(SteppedSession):
    """The ends of a scenario, stepped tick by tick for a day at most; ``targets`` are those of the
    hands that a page can take, since the last tick [m]; ``scene`` is as its environment says.
    """

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(replace(scenario, duration_s=86400.0))
        self.tick = self._stepped = 0
        self.scene = description_of(self.server.s.environment.body)
        self.targets: dict[str, list[Target]] = {}
        for user in self.users:
            if user.settings.operator.is_remote:
                self.targets[name := user.settings.name] = []
                user.device.listen(partial(self._taken, name))

    def _taken(self, user: str) -> Sequence[Target]:
        new, self.targets[user] = self.targets[user], []
        return new

    def step_to(self, tick: int, feed: Feed) -> None:
        """Step up to a tick; give what was noted to a feed."""
        self.tick = tick
        self.advance(tick * self.tick_ns)
        for user in self.users:
            if user.notes.ticks:
                feed.on_master(user.traces())
            user.notes = TickNotes()
        if self.steps:
            began_s = self.tick_s * np.array([step.tick for step in self.steps], dtype=float)
            server = stepped_server(self._scenario, self.steps, began_s)
            feed.on_server(replace(server, step=server.step + self._stepped))
            self._stepped += len(self.steps)
        self.steps = []
        for number, link in enumerate(
            link for user in self.users for link in (user.up, user.down)
        ):
            # The newest fates; an arrival may lie ahead. No record of packets is kept.
            rows = [(f.number, f.time_in_ns, f.time_due_ns, f.kind) for f in link.fates]
            feed.on_packets(number, np.array(rows, dtype=np.float64).reshape(-1, 4))
            link.fates, link.sent, link.arrived = [], [], []


LONGEST_STEP_S = 0.25  # of virtual time at once; a machine that was busy longer loses the rest


class SimulatedSession(Session):
    """See :class:`.session.Session`."""

    def __init__(self, scenario: Scenario, *, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(live=False)
        self._clock = clock
        self._begin(scenario)

    def _begin(self, scenario: Scenario) -> None:
        self._simulation = Simulation(scenario)
        self._show(scenario, [user.name for user in scenario.users], self._simulation.scene)
        self._feed.tape.zero(0)
        self.generation += 1
        self.remote = list(self._simulation.targets)
        self._at_s = self._clock()
        self._left_s = self._lost_s = 0.0  # of real time, not simulated yet; never simulated

    def _notes(self) -> list[str]:
        lost = f"This machine was busy: {self._lost_s:.0f} s of real time was not simulated."
        return [lost] if self._lost_s >= 0.5 else []

    def poll(self) -> Sequence[Snapshot]:
        """Simulate up to now; return the snapshots since the last call."""
        now_s = self._clock()
        passed_s, self._at_s = now_s - self._at_s, now_s
        if self.paused:
            return []
        self._left_s += min(passed_s, LONGEST_STEP_S)
        self._lost_s += max(passed_s - LONGEST_STEP_S, 0.0)
        if self._scenario != self.wanted:  # a delay never jumps
            self._scenario = ramped(self._scenario, self.wanted, over_s=SNAPSHOT_S)
            self._simulation.change(self._scenario)
            if self._scenario == self.wanted:
                self._lags = description.lags(self._scenario, live=False)
        simulation, tick_s = self._simulation, self._simulation.tick_ns * 1e-9
        before = simulation.tick
        simulation.step_to(before + int(self._left_s / tick_s), self._feed)
        self._left_s -= (simulation.tick - before) * tick_s
        return self._snapshots(simulation.tick * simulation.tick_ns)

    def _give(self, user: str, position: Sequence[float] | None) -> None:
        self._simulation.targets[user].append(None if position is None else value(tuple(position)))

    async def _change(self, control: Control, wanted: Scenario, value: Setting) -> str:
        self.wanted = wanted
        self._name_network(control, value)
        return ""

    async def pause(self, paused: bool) -> Handled:
        """Let time stand still, or go on."""
        self.paused = paused
        return Handled(True, "paused" if paused else "running")

    def restart(self, values: Settings) -> Handled:
        """Begin again with these settings."""
        try:
            self._begin(controls.changed(self.wanted, values))
        except PmwvcError as error:
            return Handled(False, str(error))
        if controls.PRESET in values:
            self.preset = str(values[controls.PRESET])
        self.paused = False
        return Handled(True, "begun again")
