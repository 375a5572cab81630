# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session simulated in real time: the core's own ends of the protocol, stepped as far as the
clock says. Needs no ROS.

As the simulator (:mod:`pmwvc_core.simulation.session`), frame start, server step and answer are
one instant; unlike it this session has no end, and its links change while it runs.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np

from pmwvc_core.controllers import has_waves
from pmwvc_core.frame.assembly import server_step_of
from pmwvc_core.frame.force_loop import SIGNALS
from pmwvc_core.frame.schedule import next_on_grid
from pmwvc_core.frame.server_step import ServerRow
from pmwvc_core.numeric import Array, Value
from pmwvc_core.plant.remote_hand import RemoteHand, Target
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.simulation.user import SimulatedUser
from pmwvc_view.feed import traces
from pmwvc_view.feed.accounts import MasterSums, ServerSums
from pmwvc_view.feed.feed import Feed
from pmwvc_view.feed.traces import Block, Step

CONDITIONS = Conditions()
LONGEST = 8  # ticks at once, so that a page is shown often enough
_COLUMNS = [SIGNALS.index(name) for name in traces.SIGNALS]


class PageTargets:
    """The targets that a page gives to a hand: the newest one [m], once; None: it is open."""

    early = True

    def __init__(self) -> None:
        self._new: list[Target] = []
        self.newest: Target = None

    def give(self, target: Target) -> None:
        """Note a target; None lets go."""
        self._new.append(target)
        self.newest = target

    def take(self) -> Sequence[Target]:
        """Return what came since the last tick."""
        new, self._new = self._new, []
        return new


class Simulation:
    """The ends of a scenario, stepped tick by tick without an end; its traces go to a feed.

    ``epoch`` is the number of this beginning.
    """

    def __init__(self, scenario: Scenario, feed: Feed, *, epoch: int) -> None:
        self._feed, self._epoch = feed, epoch
        self._names = [user.name for user in scenario.users]
        self._waves = has_waves(scenario.controller)
        self._dof = scenario.dof
        self._server = server_step_of(scenario)
        self._users = [
            SimulatedUser(scenario, i, runs=1, server_inbox=inbox, conditions=CONDITIONS)
            for i, inbox in enumerate(self._server.inboxes)
        ]
        self._serve_at = 0  # tick of the server's next step
        self.tick_ns = round(scenario.tick_s * 1e9)
        self.targets: dict[str, PageTargets] = {}
        for user in self._users:
            if isinstance(user.operator, RemoteHand) and not user.settings.operator.file:
                self.targets[user.settings.name] = source = PageTargets()
                user.operator.source = source
        self.tick = 0

    def run(self, until_tick: int) -> None:
        """Step up to a tick, from one frame start or step of the server to the next."""
        while self.tick < until_tick:
            self._begin()
            begins = [self._serve_at, *(user.loop.next_frame for user in self._users)]
            after = min(*begins, self.tick + LONGEST, until_tick)
            self._advance(after)
            self.tick = after

    def change(self, old: Scenario, new: Scenario) -> None:
        """Change parameters of a running session.

        Both scenarios have one structure; what is equal in both stays as it is.
        """
        server = self._server
        if new.server != old.server:
            server.hand_over(partial(self._configure_server, new))
        for index, (user, one, other) in enumerate(
            zip(self._users, old.users, new.users, strict=True)
        ):
            user.change(one, other)
            if other.contact != one.contact:
                port = index, other.contact, other.server_impedance
                server.hand_over(partial(server.configure_user, *port))

    def _configure_server(self, new: Scenario) -> None:
        """Give the server other parameters in a step; it ends where the next one begins."""
        ends = next_on_grid(self.tick, new.period_ticks)
        self._server.configure(new.server, first_s=(ends - self.tick) * new.tick_s)

    def round_trips(self) -> dict[str, float | None]:
        """Return the measured round trip of every user, by column [s]."""
        return {
            f"{name}.round_trip": user.loop.inbox.round_trip_s
            for name, user in zip(self._names, self._users, strict=True)
        }

    def places(self) -> dict[str, Value | None]:
        """Return the target of every remote hand that is closed, by column [m]."""
        found: dict[str, Value | None] = {}
        for user in self._users:
            if isinstance(user.operator, RemoteHand):
                source = self.targets.get(user.settings.name)
                followed = user.operator.target if source is None else source.newest
                found[f"{user.settings.name}.target"] = followed if user.operator.holding else None
        return found

    def _link(self, user: int, way: int) -> SimulatedLink:
        return self._users[user].down if way else self._users[user].up

    def _begin(self) -> None:
        """Run what is due at the present tick: frame starts, and the server's step."""
        tick, now_ns = self.tick, self.tick * self.tick_ns
        for user in self._users:
            user.send(tick, now_ns)
        if tick == self._serve_at:
            self._serve(now_ns)
            every = round(self._server.params.period_s * 1e9) // self.tick_ns
            self._serve_at = next_on_grid(tick, every)

    def _advance(self, after: int) -> None:
        """Run the ticks from the present one on."""
        ticks = range(self.tick, after)
        times = [number * self.tick_ns for number in ticks]
        for name, user in zip(self._names, self._users, strict=True):
            values = user.advance(ticks, times)
            self._feed.on_master(name, self._block(user, values, times))
        for index in range(len(self._users)):
            for way in (0, 1):
                self._hand_packets(2 * index + way, self._link(index, way))

    def _serve(self, now_ns: int) -> None:
        packets = [user.up.collect(now_ns) for user in self._users]
        answers, row = self._server.tick(now_ns, packets)
        for user, answer in zip(self._users, answers, strict=True):
            if answer is not None:
                user.down.send(answer, now_ns)
        if row is not None:
            self._feed.on_server(self._server_row(row, now_ns))

    def _server_row(self, row: ServerRow, now_ns: int) -> Step:
        vector = self._vector
        return Step(
            start_ns=now_ns,
            object=np.array([vector(getattr(row, name)) for name in traces.OBJECT]),
            avatars=np.array(
                [[vector(getattr(port, name)) for port in row.ports] for name in traces.AVATAR]
            ),
            state=[int(state) for state in row.state],
            contact=[bool(np.any(port.contact)) for port in row.ports],
            lateness_s=0.0,
            sums={
                name: ServerSums(now_ns, self._epoch, _one(port.energy_u_s), _one(port.energy_v_s))
                for name, port in zip(self._names, row.ports, strict=True)
            },
        )

    def _block(self, user: SimulatedUser, values: list[Value], times: Sequence[int]) -> Block:
        every = values if self._dof == 1 else [self._vector(value) for value in values]
        signals = np.array(every).reshape(len(times), len(SIGNALS), self._dof)
        report = user.loop.report()
        sums = MasterSums(
            times[-1], self._epoch, _one(report.u_m), _one(report.v_m), _one(user.device.work[0])
        )
        return Block(
            start_ns=times[0],
            period_ns=self.tick_ns,
            signals=signals[:, _COLUMNS].swapaxes(0, 1),
            lateness_s=[0.0] * len(times),
            state=int(report.state),
            reason=str(report.reason),
            missed=0,
            sums=sums,
            waves=self._waves and not report.accounts,
        )

    def _vector(self, value: Value) -> Array:
        every = np.reshape(np.asarray(value, dtype=np.float64), -1)  # one number: of all axes
        return np.broadcast_to(every, self._dof)

    def _hand_packets(self, number: int, link: SimulatedLink) -> None:
        """Hand the newest fates over; an arrival may lie ahead. No record of packets is kept."""
        fates = link.fates
        if fates:
            rows = [(f.number, f.time_in_ns, f.time_due_ns, int(f.kind)) for f in fates]
            self._feed.on_packets(number, np.array(rows, dtype=np.float64))
        link.fates, link.sent, link.arrived = [], [], []


def _one(value: Value) -> float:
    """Return the number of the only run."""
    return float(np.ravel(value)[0])
