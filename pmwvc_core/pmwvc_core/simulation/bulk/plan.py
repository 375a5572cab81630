# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The plan of a session's network: which packet is sent when, where it goes, what its receiver
makes of its number.

None of that depends on a signal (without a deadband): so it is worked out before the session, once
for all sessions with the same network, and what is left is arithmetic. Who sends a wave that no
receiver takes departs from the plan; such a session is stepped with its packets instead.
"""

import dataclasses
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pmwvc_core.ends.server_end import SERVER_EPOCH
from pmwvc_core.frame.schedule import AT_ONCE
from pmwvc_core.law.user_tick import next_on_grid
from pmwvc_core.network.effects import is_random
from pmwvc_core.network.link import stream_of
from pmwvc_core.numeric import Integers
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.transport.packet import Packer, Verdict
from pmwvc_core.transport.receiver import Receiver

TAKEN = (Verdict.ACCEPTED, Verdict.NEW_EPOCH)


class Network(NamedTuple):
    """What decides on the plan of a session."""

    links: tuple[tuple[LinkParams, LinkParams], ...]  # up and down of each user
    seed: int  # of random links, else 0
    ticks: int
    tick_ns: int
    rate_drops: tuple[int, ...]
    period_ticks: int
    timeouts_s: tuple[float, ...]
    server_timeout_s: float
    release_s: float
    dof: int


@dataclasses.dataclass(frozen=True, eq=False)
class Plan:
    """The links after the session, with packets of nothing, and what was accepted at their ends.

    Attributes
    ----------
    up, down
        Links of every user.
    taken_up, taken_down
        Packets accepted, ``(accepted, 5)`` in the order of time: tick, user, which of those sent
        from 0, whether it is a beginning, how many were lost before it.
    looks_ns
        When the server and the masters looked.
    """

    up: list[SimulatedLink]
    down: list[SimulatedLink]
    taken_up: Integers
    taken_down: Integers
    looks_ns: tuple[range, range]


def network_of(scenario: Scenario) -> Network:
    """Return what decides on the plan of a scenario."""
    users, tick_s = scenario.users, scenario.tick_s
    links = tuple((user.link_up, user.link_down) for user in users)
    times = scenario.times
    return Network(
        links,
        scenario.seed if any(is_random(link) for both in links for link in both) else 0,
        round(scenario.duration_s / tick_s),
        round(tick_s * 1e9),
        tuple(user.master.rate_drop for user in users),
        scenario.period_ticks,
        tuple(user.safety.timeout_s for user in users),
        times.timeout_s,
        times.release_s,
        scenario.dof,
    )


@lru_cache(maxsize=8)
def plan_of(network: Network) -> Plan:
    """Return the plan of a network."""
    return _Planner(network).run()


class _End:
    """One direction: a sender with packets of nothing, the link, the receiver."""

    def __init__(self, network: Network, user: int, direction: int, epoch: int) -> None:
        tick_s = network.tick_ns * 1e-9
        lengths = network.rate_drops[user], network.period_ticks
        timeout_s = (network.server_timeout_s, network.timeouts_s[user])[direction]
        self.inbox = Receiver(
            network.dof, period_s=lengths[direction] * tick_s, timeout_s=timeout_s
        )
        self.link = SimulatedLink(
            network.links[user][direction],
            seed=stream_of(network.seed, user, direction),
            inbox=self.inbox,
            dof=network.dof,
            direction=direction,
        )
        self.packer = Packer(epoch, period=lengths[direction] * tick_s)
        self._nothing = 0.0 if network.dof == 1 else np.zeros(network.dof)
        self.rows: list[tuple[int, int, int, int, int]] = []
        self._user = user
        self._tick_ns = network.tick_ns

    def send(self, tick: int, peer: Receiver) -> None:
        now_ns = tick * self._tick_ns
        zero = self._nothing
        self.link.send(self.packer.pack(zero, zero, now_ns, 0, peer.echo(now_ns)), now_ns)

    def look(self, tick: int) -> None:
        """Take in what has come by a tick."""
        now_ns = tick * self._tick_ns
        for packet in self.link.collect(now_ns):
            lost = self.inbox.lost
            verdict = self.inbox.push(packet, now_ns)
            if verdict in TAKEN:
                begins, missing = verdict is not TAKEN[0], self.inbox.lost - lost
                self.rows.append((tick, self._user, packet.seq - 1, begins, missing))

    def due_tick(self) -> float:
        """Return the tick at which the next packet can be taken in."""
        due_ns = self.link.link.next_due_ns
        return math.inf if due_ns is None else -(-due_ns // self._tick_ns)


def _in_order(ends: list[_End]) -> Integers:
    rows = sorted((row for end in ends for row in end.rows), key=lambda row: row[0])
    return np.array(rows, dtype=np.int64).reshape(len(rows), 5)


class _Planner:
    """The frame protocol without its signals."""

    def __init__(self, network: Network) -> None:
        self._network = network
        users = range(len(network.links))
        self._up = [_End(network, user, 0, user + 1) for user in users]
        self._down = [_End(network, user, 1, SERVER_EPOCH + user) for user in users]
        self._present = [False for _ in users]
        self._release_ns = network.release_s * 1e9

    def run(self) -> Plan:
        network = self._network
        frames = [0 for _ in self._up]
        step = next_on_grid(
            -1,
            network.period_ticks,
            AT_ONCE.server_tick(tick_s=network.tick_ns * 1e-9, period_ticks=network.period_ticks),
        )
        while (tick := min(step, *frames)) < network.ticks:
            for user, down in enumerate(self._down):
                while down.due_tick() < tick:
                    down.look(int(down.due_tick()))
                if frames[user] == tick:
                    self._up[user].send(tick, down.inbox)
                    frames[user] += network.rate_drops[user]
            if tick == step:
                self._step(tick)
                step += network.period_ticks
            for down in self._down:
                if down.due_tick() <= tick:
                    down.look(tick)
        end_ns = network.ticks * network.tick_ns
        for end in (*self._up, *self._down):
            while end in self._down and end.due_tick() < network.ticks:
                end.look(int(end.due_tick()))
            end.link.drain(end_ns)
        tick_ns = network.tick_ns
        return Plan(
            [end.link for end in self._up],
            [end.link for end in self._down],
            _in_order(self._up),
            _in_order(self._down),
            (range(0, end_ns, network.period_ticks * tick_ns), range(0, end_ns, tick_ns)),
        )

    def _step(self, tick: int) -> None:
        """Take packets in at the server and answer those users who are present."""
        now_ns = tick * self._network.tick_ns
        for user, (up, down) in enumerate(zip(self._up, self._down, strict=True)):
            before = len(up.link.arrived)
            up.look(tick)
            self._present[user] |= len(up.link.arrived) > before and up.inbox.newest is not None
            if now_ns - up.inbox.accepted_ns > self._release_ns:
                self._present[user] = False
            if self._present[user]:
                down.send(tick, up.inbox)
