# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session of a page that is simulated in real time."""

import time
from collections.abc import Callable, Sequence

from pmwvc_core.ends.forms import value
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view import controls, description
from pmwvc_view.controls import Control, Setting, Settings
from pmwvc_view.protocol.snapshot import Snapshot
from pmwvc_view.session import Answer, RunningSession, State, ramped
from pmwvc_view.simulated.stepping import Simulation

LONGEST_STEP_S = 0.25  # of virtual time at once; a machine that was busy longer loses the rest


class SimulatedSession(RunningSession):
    """See :class:`.session.Session`."""

    def __init__(
        self, scenario: Scenario, *, snapshot_s: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(live=False, snapshot_s=snapshot_s)
        self._clock, self._paused = clock, False
        self._preset: str | None = None
        self._begin(scenario)

    def _begin(self, scenario: Scenario) -> None:
        self._show(scenario, [user.name for user in scenario.users])
        self._wanted = scenario
        self.generation += 1
        self._simulation = Simulation(scenario, self._feed, epoch=self.generation)
        self._at_s = self._clock()
        self._left_s = 0.0  # of real time, not simulated yet
        self._lost_s = 0.0  # never simulated

    def _state(self) -> State:
        lost = f"This machine was busy: {self._lost_s:.0f} s of real time was not simulated."
        return State(self._paused, self._preset, [lost] if self._lost_s >= 0.5 else [])

    def _remote(self) -> list[str]:
        return list(self._simulation.targets)

    def poll(self) -> Sequence[Snapshot]:
        """Simulate up to now; return the snapshots since the last call."""
        now_s = self._clock()
        passed_s, self._at_s = now_s - self._at_s, now_s
        if self._paused:
            return []
        if passed_s > LONGEST_STEP_S:
            self._lost_s += passed_s - LONGEST_STEP_S
            passed_s = LONGEST_STEP_S
        self._left_s += passed_s
        if self._scenario != self._wanted:  # a delay never jumps
            self._scenario = ramped(self._scenario, self._wanted, over_s=self._snapshot_s)
            self._simulation.change(self._scenario)
            if self._scenario == self._wanted:
                self._lags = description.lags(self._scenario, live=False)
        simulation, tick_s = self._simulation, self._simulation.tick_ns * 1e-9
        before = simulation.tick
        simulation.run(before + int(self._left_s / tick_s))
        self._left_s -= (simulation.tick - before) * tick_s
        places = simulation.places()
        held = {name.replace(".target", ".held"): at is not None for name, at in places.items()}
        self._feed.others = {**self._lags, **simulation.round_trips(), **places, **held}
        snapshots = self._feed.rows(simulation.tick * simulation.tick_ns)
        self._notices.watch(snapshots, self.layout, self._names)
        return snapshots

    def target(self, user: str, position: tuple[float, ...] | None) -> None:
        """Give a hand its newest target [m]; None opens it."""
        if source := self._simulation.targets.get(user):
            target = description.within_workspace(position, self._scenario, user)
            source.give(None if target is None else value(tuple(target)))

    async def _change(self, control: Control, wanted: Scenario, value: Setting) -> str:
        self._wanted = wanted
        if control.node == "netem":
            self._preset = str(value) if control.path == controls.PRESET else None
        return ""

    def scenario(self) -> Scenario:
        """Return the scenario that settings are added to."""
        return self._wanted

    async def pause(self, paused: bool) -> Answer:
        """Let time stand still, or go on."""
        self._paused = paused
        return Answer(True, "paused" if paused else "running")

    def restart(self, values: Settings) -> Answer:
        """Begin again with these settings."""
        try:
            scenario = controls.changed(self._wanted, values)
            self._begin(scenario)
        except PmwvcError as error:
            return Answer(False, str(error))
        if controls.PRESET in values:
            self._preset = str(values[controls.PRESET])
        self._paused = False
        return Answer(True, "begun again")
