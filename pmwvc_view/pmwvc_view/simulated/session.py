# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session of a page that is simulated in real time."""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pmwvc_analysis.budget.energy import declared_storage_j
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import signal
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view import controls, description
from pmwvc_view.controls import Setting, Settings
from pmwvc_view.feed.feed import Feed
from pmwvc_view.feed.notices import Notices
from pmwvc_view.feed.verdict import verdict
from pmwvc_view.prediction import Predictor
from pmwvc_view.protocol.snapshot import Layout
from pmwvc_view.protocol.snapshots import Snapshot
from pmwvc_view.session import BEGIN_ANEW, Answer, Session
from pmwvc_view.simulated.ramp import ramped
from pmwvc_view.simulated.stepping import Simulation

LONGEST_STEP_S = 0.25  # of virtual time at once; a machine that was busy longer loses the rest
TEXT_EVERY = 8  # snapshots between two verdicts


class SimulatedSession(Session):
    """See :class:`.session.Session`."""

    can = frozenset({"take", "let_go", "target", "set", "ask", "pause", "restart", "seen"})

    def __init__(
        self, scenario: Scenario, *, snapshot_s: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._clock, self._snapshot_s = clock, snapshot_s
        super().__init__(Predictor(live=False))
        self._paused = False
        self._preset: str | None = None
        self._values = controls.Values()
        self._begin(scenario)

    def _begin(self, scenario: Scenario) -> None:
        self._wanted = self._scenario = scenario
        self._names = [user.name for user in scenario.users]
        self.generation += 1
        self.layout = Layout(self._names, scenario.dof)
        period_ns = round(self._snapshot_s * 1e9)
        self._feed = Feed(self.layout, self._names, period_ns=period_ns, scenario=scenario)
        self._simulation = Simulation(scenario, self._feed, epoch=self.generation)
        self._at_s = self._clock()
        self._left_s = 0.0  # of real time, not simulated yet
        self._lost_s = 0.0  # never simulated
        self._notices = Notices()
        self._text: dict[str, Any] = {}
        self._polls = 0
        self._storage_j = {
            user.name: declared_storage_j(scenario.controller, user) for user in scenario.users
        }
        self._exact = self._names  # a simulated device counts its true motion
        self._lags = description.lags(scenario, live=False)

    def description(self) -> dict[str, Any]:
        """Return the session message without what the server adds."""
        return description.describe(
            self._scenario,
            mode="simulated",
            duration_s=None,
            values=controls.values_of(self._wanted, self._preset),
            remote=list(self._simulation.targets),
        )

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
        self._follow()
        simulation, tick_s = self._simulation, self._simulation.tick_ns * 1e-9
        before = simulation.tick
        simulation.run(before + int(self._left_s / tick_s))
        self._left_s -= (simulation.tick - before) * tick_s
        places = {f"{user}.held": place is not None for user, place in self._held().items()}
        self._feed.others = {
            **self._lags,
            **simulation.round_trips(),
            **simulation.places(),
            **places,
        }
        snapshots = self._feed.rows(simulation.tick * simulation.tick_ns)
        self._notices.watch(snapshots, self.layout, self._names)
        return snapshots

    def _held(self) -> Mapping[str, Any]:
        return {
            column.removesuffix(".target"): place
            for column, place in self._simulation.places().items()
        }

    def _follow(self) -> None:
        """Change what is wanted otherwise; a delay never jumps."""
        if self._scenario == self._wanted:
            return
        self._scenario = ramped(self._scenario, self._wanted, over_s=self._snapshot_s)
        self._simulation.change(self._scenario)
        if self._scenario == self._wanted:
            self._lags = description.lags(self._scenario, live=False)

    def news(self) -> Mapping[str, Mapping[str, Any]]:
        """Return verdict, values of controls, and whether time passes."""
        self._polls += 1
        if self._polls % TEXT_EVERY == 1:
            self._text = verdict(
                self._feed,
                self._names,
                storage_j=self._storage_j,
                exact_hands=self._exact,
                notices=self._lost() + self._notices.texts(),
            )
        return {
            "text": self._text,
            "values": {"values": self._values(self._wanted, self._preset)},
            "play": {"paused": self._paused, "time_s": None, "ratio": 1.0},
        }

    def _lost(self) -> list[str]:
        if self._lost_s < 0.5:
            return []
        return [f"This machine was busy: {self._lost_s:.0f} s of real time were not simulated."]

    def target(self, user: str, position: tuple[float, ...] | None) -> None:
        """Give a hand its newest target [m]; None opens it."""
        source = self._simulation.targets.get(user)
        if source is not None:
            place = description.place(position, self._scenario, user)
            source.give(None if place is None else signal(place, self._scenario.dof))

    async def set(self, path: str, value: Setting) -> Answer:
        """Change a parameter."""
        try:
            control = controls.control_of(path)
            controls.require_changeable(self._wanted, control)
            wanted = controls.changed(self._wanted, {path: value})
        except PmwvcError as error:
            return Answer(False, str(error))
        if control.path in controls.AT_RESTART:
            return Answer(False, f"{path}: {BEGIN_ANEW}")
        self._notices.changed(self._wanted, wanted)
        self._wanted = wanted
        if control.node == "netem":
            self._preset = str(value) if control.path == controls.PRESET else None
        return Answer(True, f"{path} = {value}")

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
