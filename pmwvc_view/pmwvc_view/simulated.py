# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session of a page that is simulated in real time: virtual time as far as the clock says.

Unlike a simulation it has no end, and its parameters change while it runs. Needs no ROS.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.ends.inbox import scalar, value, vector
from pmwvc_core.ends.user_end import Target
from pmwvc_core.errors import PmwvcError
from pmwvc_core.frame import SIGNALS, Frame, ServerRow
from pmwvc_core.numeric import Value
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.virtual_time import VirtualTime
from pmwvc_view import SNAPSHOT_S, controls, description
from pmwvc_view.controls import Control, Setting, Settings
from pmwvc_view.feed import tape
from pmwvc_view.feed.balances import NO_WAVES, ways
from pmwvc_view.feed.feed import Feed
from pmwvc_view.feed.tape import TraceBlock, TraceStep
from pmwvc_view.protocol.snapshot import Snapshot
from pmwvc_view.session import Handled, Session, ramped

LONGEST = 8  # ticks at once, so that a page is shown often enough
_COLUMNS = [SIGNALS.index(name) for name in tape.KEPT]


class Simulation:
    """The ends of a scenario, stepped tick by tick without an end; its traces go to a feed.
    ``epoch`` is the number of this beginning; ``targets`` are those of the hands that a page can
    take, since the last tick [m].
    """

    def __init__(self, scenario: Scenario, feed: Feed, *, epoch: int) -> None:
        self._feed, self._epoch, self._dof = feed, epoch, scenario.dof
        self._waves = has_waves(scenario.controller)
        self._time = VirtualTime(scenario, on_frame=self._show_frame, on_step=self._show_step)
        names = [user.name for user in scenario.users]
        self._users = dict(zip(names, self._time.users, strict=True))
        self.change, self.tick_ns, self.tick = self._time.change, self._time.tick_ns, 0
        self.targets: dict[str, list[Target]] = {}
        self._newest: dict[str, Target] = {}
        for name, user in self._users.items():
            if user.settings.operator.is_remote:
                self.targets[name] = []
                user.device.listen(partial(self._taken, name))

    def give(self, user: str, target: Target) -> None:
        """Give a hand its newest target [m]; None opens it."""
        self.targets[user].append(target)
        self._newest[user] = target

    def _taken(self, user: str) -> Sequence[Target]:
        new, self.targets[user] = self.targets[user], []
        return new

    def run(self, until_tick: int) -> None:
        """Step up to a tick."""
        while self.tick < until_tick:
            self.tick = min(self.tick + LONGEST, until_tick)
            self._time.advance(self.tick * self.tick_ns)
            links = (link for user in self._time.users for link in (user.up, user.down))
            for number, link in enumerate(links):
                # The newest fates; an arrival may lie ahead. No record of packets is kept.
                rows = [(f.number, f.time_in_ns, f.time_due_ns, f.kind) for f in link.fates]
                if rows:
                    self._feed.on_packets(number, np.array(rows, dtype=np.float64))
                link.fates, link.sent, link.arrived = [], [], []

    def places(self) -> dict[str, Value | None]:
        """Return the target of every remote hand by user [m]; None: it is open."""
        found: dict[str, Value | None] = {}
        for name, user in self._users.items():
            if hand := user.device.remote:
                followed = self._newest.get(name) if name in self.targets else value(hand.target)
                found[name] = followed if hand.holding else None
        return found

    def _show_step(self, _: int, now_ns: int, row: ServerRow) -> None:
        of = partial(vector, dof=self._dof)
        step = TraceStep(
            start_ns=now_ns, epoch=self._epoch,
            object=np.array([of(getattr(row, name)) for name in tape.OBJECT]),
            avatars=np.array([[*map(of, getattr(row, name))] for name in tape.AVATAR]),
            state=row.state, contact=[bool(touches) for touches in row.contact], lateness_s=0.0,
            sums=np.array([[*map(scalar, row.energy_u_s)], [*map(scalar, row.energy_v_s)]]),
        )  # fmt: skip
        self._feed.on_server(step)

    def _show_frame(self, index: int, frame: Frame) -> None:
        (name, user), times = list(self._users.items())[index], frame.times_ns
        every = [vector(each, self._dof) for each in frame.values]
        signals = np.array(every).reshape(len(times), len(SIGNALS), self._dof)
        report, (up, down) = user.loop.report(), NO_WAVES
        if self._waves:
            kept = {entry: scalar(joules) for entry, joules in report.accounts.items()}
            up, down = ways(scalar(report.u_m), scalar(report.u_tx), scalar(report.v_m), kept)
        block = TraceBlock(
            start_ns=times[0], period_ns=self.tick_ns, signals=signals[:, _COLUMNS].swapaxes(0, 1),
            lateness_s=[0.0] * len(times), state=int(report.state), reason=str(report.reason),
            missed=0, epoch=self._epoch, sums=(up, down, user.device.s.against_j),
        )  # fmt: skip
        self._feed.on_master(name, block)


LONGEST_STEP_S = 0.25  # of virtual time at once; a machine that was busy longer loses the rest


class SimulatedSession(Session):
    """See :class:`.session.Session`."""

    def __init__(self, scenario: Scenario, *, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(live=False)
        self._clock, self._paused = clock, False
        self._preset: str | None = None
        self._begin(scenario)

    def _begin(self, scenario: Scenario) -> None:
        self._show(scenario, [user.name for user in scenario.users])
        self._wanted = scenario
        self.generation += 1
        self._simulation = Simulation(scenario, self._feed, epoch=self.generation)
        self._at_s = self._clock()
        self._left_s = self._lost_s = 0.0  # of real time, not simulated yet; never simulated

    def _state(self) -> tuple[bool, list[str]]:
        lost = f"This machine was busy: {self._lost_s:.0f} s of real time was not simulated."
        return self._paused, [lost] if self._lost_s >= 0.5 else []

    def _preset_name(self) -> str | None:
        return self._preset

    def _remote(self) -> Sequence[str]:
        return list(self._simulation.targets)

    def poll(self) -> Sequence[Snapshot]:
        """Simulate up to now; return the snapshots since the last call."""
        now_s = self._clock()
        passed_s, self._at_s = now_s - self._at_s, now_s
        if self._paused:
            return []
        self._left_s += min(passed_s, LONGEST_STEP_S)
        self._lost_s += max(passed_s - LONGEST_STEP_S, 0.0)
        if self._scenario != self._wanted:  # a delay never jumps
            self._scenario = ramped(self._scenario, self._wanted, over_s=SNAPSHOT_S)
            self._simulation.change(self._scenario)
            if self._scenario == self._wanted:
                self._lags = description.lags(self._scenario, live=False)
        simulation, tick_s = self._simulation, self._simulation.tick_ns * 1e-9
        before = simulation.tick
        simulation.run(before + int(self._left_s / tick_s))
        self._left_s -= (simulation.tick - before) * tick_s
        return self._snapshots(simulation.tick * simulation.tick_ns, simulation.places())

    def target(self, user: str, position: tuple[float, ...] | None) -> None:
        """Give a hand its newest target [m]; None opens it."""
        if user in self._simulation.targets:
            target = description.within_workspace(position, self._scenario, user)
            self._simulation.give(user, None if target is None else value(tuple(target)))

    async def _change(self, control: Control, wanted: Scenario, value: Setting) -> str:
        self._wanted = wanted
        if control.node == "netem":
            self._preset = str(value) if control.path == controls.PRESET else None
        return ""

    def scenario(self) -> Scenario:
        """Return the scenario that settings are added to."""
        return self._wanted

    async def pause(self, paused: bool) -> Handled:
        """Let time stand still, or go on."""
        self._paused = paused
        return Handled(True, "paused" if paused else "running")

    def restart(self, values: Settings) -> Handled:
        """Begin again with these settings."""
        try:
            self._begin(controls.changed(self._wanted, values))
        except PmwvcError as error:
            return Handled(False, str(error))
        if controls.PRESET in values:
            self._preset = str(values[controls.PRESET])
        self._paused = False
        return Handled(True, "begun again")
