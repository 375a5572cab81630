# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The laws of a whole session, from a state to a state: users, server, devices and hands, with
packets that come at once, late or never.
"""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from pmwvc_core.law.server_step import server_step
from pmwvc_core.law.user_tick import Sample, begin, send, user_tick
from pmwvc_core.plant.device import device_step
from pmwvc_core.plant.forces import hand_force
from pmwvc_core.simulation.bulk.run import prepared
from pmwvc_core.unrolled import unrolled


class Link(NamedTuple):
    """Number of the newest packet on its way, and those that have not been taken."""

    newest: int
    waiting: tuple


class Session(NamedTuple):
    """Both ends of a session with their links, devices and hands."""

    users: tuple
    server: object
    devices: tuple
    hands: tuple
    up: tuple
    down: tuple


class Laws:
    """Those of a scenario, as written or unrolled."""

    def __init__(self, scenario, seed, *, unroll):
        names = ("ends", "server", "users", "p", "clock", "task")
        self.made = SimpleNamespace(**dict(zip(names, prepared(scenario)[0], strict=True)))
        self.seed, self.axes = seed, scenario.dof
        self.period = self.made.clock.period_ticks
        laws = send, begin, user_tick, server_step
        self.send, self.begin, self.tick, self.step = (
            unrolled(law, self.axes) if unroll else law for law in laws
        )

    @property
    def start(self):
        users, devices, hands, *_ = zip(*self.made.ends, strict=True)
        return Session(
            users, self.made.server, devices, hands, *((Link(0, ()),) * len(devices),) * 2
        )

    def run(self, s, ticks):
        """Go through the ticks; return the state behind them, and what came out, as text."""
        found = []
        for tick in ticks:
            now_ns = tick * self.made.clock.tick_ns
            rng = np.random.default_rng([self.seed, tick])
            dead = np.random.default_rng([self.seed, tick // 100]).random() < 0.3
            s = self._tick(s, tick, now_ns, 0.0 if dead else 0.9, rng, found)
        return s, repr(found)

    def _tick(self, s, tick, now_ns, odds, rng, found):
        users, server, devices, hands, up, down = (
            list(each) if type(each) is tuple else each for each in s
        )
        samples = [
            Sample(device.read_x, device.read_xd, True, now_ns, False) for device in devices
        ]
        for i, (p, sample) in enumerate(zip(self.made.users, samples, strict=True)):
            if tick >= users[i].next_frame:
                user, packet, sends = self.send(users[i], now_ns, sample, False, p.user)
                users[i] = self.begin(user, tick, p.user)
                found.append(packet)
                if sends and rng.random() < odds:
                    up[i] = posted(up[i], packet)
        if tick % self.period == 0:
            up, packets = taken(up, rng)
            server, answers = self.step(server, now_ns, tuple(packets), 0.0, self.made.p)
            found += [server.environment, answers]
            for i, (packet, sends) in enumerate(answers):
                if sends and rng.random() < odds:
                    down[i] = posted(down[i], packet)
        down, packets = taken(down, rng)
        for i, (p, sample) in enumerate(zip(self.made.users, samples, strict=True)):
            device = devices[i]
            acts = users[i].limits.ready
            hands[i], f_h = hand_force(hands[i], device.x, device.xd, acts, p.hand)
            users[i], f_m, f = self.tick(users[i], tick, now_ns, sample, packets[i], p.user)
            devices[i], *read = device_step(device, f_h, f, p.device)
            found += [f_m, f, f_h, read, users[i].limits.cause]
        return Session(tuple(users), server, *map(tuple, (devices, hands, up, down)))


def posted(link, packet):
    """Return a link with a packet on its way, as it will be accepted."""
    lost = packet.number - link.newest - 1 if link.newest else 0
    packet = packet._replace(fresh=link.newest == 0, lost=lost, epoch=1)
    return Link(packet.number, (*link.waiting, packet))


def taken(links, rng):
    """Return links and what comes out of each: all that waits, or nothing yet."""
    came = [list(link.waiting) if rng.random() < 0.8 else [] for link in links]
    left = [
        link._replace(waiting=()) if each else link for link, each in zip(links, came, strict=True)
    ]
    return left, came
