# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The plan of a session's network: which packet is sent when, where it goes, what its receiver
makes of its number.

None of that depends on a signal (without a deadband), so it is worked out before the session, once
for all with the same network. A session that sends a wave that no receiver takes departs from the
plan; it is stepped with its packets instead.
"""

import dataclasses
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pmwvc_core.ends.server_end import SERVER_EPOCH
from pmwvc_core.network.effects import is_random
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.bulk.loop import Taken
from pmwvc_core.simulation.conditions import SimulatedLink
from pmwvc_core.transport.packet import Receipt, WavePacket
from pmwvc_core.transport.receiver import Receiver

TAKEN = (Receipt.ACCEPTED, Receipt.NEW_EPOCH)


class Network(NamedTuple):
    """What decides on the plan of a session."""

    links: tuple[tuple[LinkParams, LinkParams], ...]  # up and down of each user
    seed: int  # of random links, else 0
    ticks: int
    tick_ns: int
    rate_drops: tuple[int, ...]
    period_ticks: int
    release_s: float
    dof: int


@dataclasses.dataclass(frozen=True, eq=False)
class Plan:
    """The links of every user after the session, with packets of nothing; what their receivers
    take; when the server and the masters look [ns].
    """

    up: list[SimulatedLink]
    down: list[SimulatedLink]
    taken_up: tuple[Taken, ...]
    taken_down: tuple[Taken, ...]
    looks_ns: tuple[range, range]


def network_of(scenario: Scenario) -> Network:
    """Return what decides on the plan of a scenario."""
    users, tick_s = scenario.users, scenario.tick_s
    links = tuple((user.link_up, user.link_down) for user in users)
    seed = scenario.seed if any(is_random(link) for both in links for link in both) else 0
    times = round(scenario.duration_s / tick_s), round(tick_s * 1e9)
    rate_drops = tuple(user.master.rate_drop for user in users)
    period_ticks, release_s = scenario.period_ticks, scenario.times.release_s
    return Network(links, seed, *times, rate_drops, period_ticks, release_s, scenario.dof)


@lru_cache(maxsize=8)
def plan_of(network: Network) -> Plan:
    """Return the plan of a network: the frame protocol without its signals."""
    users, every, tick_ns = range(len(network.links)), network.period_ticks, network.tick_ns
    up, down = ([_End(network, user, way) for user in users] for way in (0, 1))
    present, frames, step = [False for _ in users], [0 for _ in users], 0
    while (tick := min(step, *frames)) < network.ticks:
        for user in users:
            down[user].look_before(tick)
            if frames[user] == tick:
                up[user].send(tick, down[user].inbox)
                frames[user] += network.rate_drops[user]
        if tick == step:  # the server takes packets in, and answers those who are present
            for user in users:
                before, inbox = len(up[user].link.arrived), up[user].inbox
                up[user].look(tick)
                came = len(up[user].link.arrived) > before and inbox.newest is not None
                silent_ns = tick * tick_ns - inbox.accepted_ns
                present[user] = (present[user] or came) and silent_ns <= network.release_s * 1e9
                if present[user]:
                    down[user].send(tick, inbox)
            step += every
    end_ns = network.ticks * tick_ns
    for end in down:
        end.look_before(network.ticks)
    for end in (*up, *down):
        end.link.drain(end_ns)
    links = [end.link for end in up], [end.link for end in down]
    taken_up, taken_down = (tuple(end.taken(network.ticks) for end in ends) for ends in (up, down))
    looks_ns = range(0, end_ns, every * tick_ns), range(0, end_ns, tick_ns)
    return Plan(*links, taken_up, taken_down, looks_ns)


class _End:
    """One direction (0 up, 1 down): a sender with packets of nothing, the link, the receiver."""

    def __init__(self, network: Network, user: int, direction: int) -> None:
        self._tick_ns, self._looks = network.tick_ns, (network.period_ticks, 1)[direction]
        every = (network.rate_drops[user], network.period_ticks)[direction]
        period_s = every * (network.tick_ns * 1e-9)
        # It follows one sender all along: how long one may be silent decides on nothing here.
        self.inbox = Receiver(network.dof, period_s=period_s, timeout_s=network.release_s)
        params, seed = network.links[user][direction], (network.seed, user, direction)
        link = Link(params, seed=seed, direction=direction)
        self.link = SimulatedLink(link, self.inbox, network.dof)
        zero = 0.0 if network.dof == 1 else np.zeros(network.dof)
        self._head = (user + 1, SERVER_EPOCH + user)[direction], period_s, (zero, zero, 0.0, zero)
        self._rows: list[tuple[int, int, int, int]] = []  # tick, and what a :class:`Taken` has

    def send(self, tick: int, peer: Receiver) -> None:
        now_ns, number = tick * self._tick_ns, len(self.link.sent) + 1
        epoch, period_s, sums = self._head
        packet = WavePacket(epoch, number, now_ns, period_s, *sums, *peer.echo(now_ns))
        self.link.send(packet, now_ns)

    def look(self, tick: int) -> None:
        """Take in what has come by a tick."""
        now_ns = tick * self._tick_ns
        for packet in self.link.collect(now_ns):
            lost = self.inbox.lost
            if (verdict := self.inbox.push(packet, now_ns)) in TAKEN:
                begins, missing = verdict is not TAKEN[0], self.inbox.lost - lost
                self._rows.append((tick, packet.seq - 1, begins, missing))

    def look_before(self, tick: int) -> None:
        """Take in what comes before a tick, each at its own."""
        while (due_ns := self.link.link.next_due_ns) is not None:
            due_tick = -(-due_ns // self._tick_ns)
            if due_tick >= tick:
                return
            self.look(due_tick)

    def taken(self, ticks: int) -> Taken:
        """Return what the receiver has taken in so many ticks."""
        rows = np.array(self._rows, dtype=np.int64).reshape(-1, 4)
        looks = np.arange(0, ticks + self._looks, self._looks)
        return Taken(rows[:, 1:].copy(), np.searchsorted(rows[:, 0], looks))
