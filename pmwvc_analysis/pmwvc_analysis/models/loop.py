# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of a scenario, stepped tick by tick in the order of the simulator, or with the phases
of a live session (:data:`pmwvc_core.frame.LIVE`). Links have a constant delay; there are
no limits and no brakes.

The clocks of the playouts do not depend on signals (:mod:`pmwvc_core.law.channel.pace`). Where
frames and steps are not equally long, segments come early and late in turn; the lag that follows
them comes to one course around the hyperperiod, whatever the beginning was, and the model holds
for that.

Equations: docs/theory.md 15.3.
"""

import functools
import itertools
import math
from collections.abc import Sequence
from typing import Any

from pmwvc_analysis.models import links
from pmwvc_analysis.models.elements import lifted
from pmwvc_analysis.models.ends import LoopState, made
from pmwvc_analysis.models.linear import axes_of, require_linear
from pmwvc_core.errors import PmwvcError
from pmwvc_core.law.channel.pace import RESTING_PACE, Pace, pace_arrive, pace_step
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.channel.playout import add
from pmwvc_core.law.port.master import Sample
from pmwvc_core.law.server_step import server_step
from pmwvc_core.law.user_tick import begin, send, user_tick
from pmwvc_core.law.vectors import Vector, zero
from pmwvc_core.plant.device import device_step
from pmwvc_core.scenario.scenario import Scenario

AT_REST = send, begin, user_tick, server_step, device_step  # on plain numbers, quicker
LIFTED = tuple(map(lifted, AT_REST))
LONGEST = 20000  # ticks of a hyperperiod
SETTLED_S = 30.0  # many times as long as the lag takes to follow
STORE_S = 0.1  # more than a settled playout has in store


class LinearLoop:
    """Both ends of scenarios and the links in between, brought to rest up to tick 0.

    Scenarios differ in what is :func:`.variation.stackable`. ``live`` takes the phases of a live
    session instead of the simulator's; ``weights`` are how many users like it each user stands
    for: so many avatars move together.
    """

    def __init__(self, *runs: Scenario, live: bool = False, weights: Sequence[int] = ()) -> None:
        require_linear(runs[0])
        self.scenario = scenario = runs[0]
        self.runs, self.tick_s, self.live, self.weights = len(runs), scenario.tick_s, live, weights
        self.ticks, self.dof = links.hyperperiod_ticks(scenario), axes_of(scenario)  # of the model
        if self.ticks > LONGEST:
            raise PmwvcError(
                f"{scenario.name}: frames and server period fit together only after {self.ticks} "
                f"ticks, more than {LONGEST}; choose rate_drop and period_s with common factors"
            )
        ports = itertools.count()
        self.lines = [
            links.line_of(user, scenario, tuple(itertools.islice(ports, n)), live=live)
            for user, n in zip(scenario.users, weights or [1] * len(scenario.users), strict=True)
        ]
        self.s, self.p = made(runs, self.lines, self.dof)
        # Every link has answered by tick 0, and what playouts had in store before is played: whole
        # hyperperiods before tick 0, and before the clocks of the playouts are set.
        apart = 4 * max(max(line.frame.period, line.serve.period) for line in self.lines)
        answered, played = max(line.delay_up + line.delay_down for line in self.lines) + apart, 0
        if scenario.strict:
            played = apart + math.ceil(STORE_S / scenario.tick_s)
        settled = -self.ticks * -(-played // self.ticks)
        whole = -(-answered // self.ticks) + 2 * scenario.strict
        self._start = settled - self.ticks * whole
        for tick in range(self._start, 0):
            if scenario.strict and tick == settled:
                self.s = _with_paces(self.s, self.lines)
            self.advance(tick, self.still, AT_REST if self.runs == 1 else LIFTED)

    @property
    def still(self) -> list[Vector]:
        """No force on any device."""
        return [(0.0,) * self.dof for _ in self.lines]

    def advance(
        self, tick: int, forces: Sequence[Vector], laws: tuple[Any, ...] = ()
    ) -> list[tuple[Vector, Vector, Vector]]:
        """Go one tick on under the hands' forces; return x, xd and f of every user."""
        send_, begin_, tick_, step_, device_ = laws or LIFTED
        number = tick - self._start
        now_ns = number * round(self.tick_s * 1e9)
        s, server = self.s, self.s.server
        loops, devices, up, down = map(list, (s.loops, s.devices, s.up, s.down))
        samples = [Sample(device.read_x, device.read_xd, True, now_ns) for device in devices]
        for i, line in enumerate(self.lines):
            if line.frame.due(tick):
                p = self.p.loops[i]
                loops[i], packet, _ = send_(loops[i], now_ns, samples[i], False, p)
                loops[i] = begin_(loops[i], number, p)
                up[i] += (links.PacketUnderWay(tick, tick + line.delay_up, packet),)
        if self.lines[0].serve.due(tick):
            came: list[list[Packet]] = []  # by port: equal users have the same
            for i, line in enumerate(self.lines):
                up[i], packets = links.arrived(up[i], tick)
                came += [packets] * len(line.ports)
            server = server._replace(guests=tuple(map(links.sums_anew, server.guests)))
            server, answers = step_(server, now_ns, tuple(came), 0.0, self.p.server)
            for i, line in enumerate(self.lines):
                packet, sends = answers[line.ports[0]]
                if sends:
                    down[i] += (links.PacketUnderWay(tick, tick + line.delay_down, packet),)
        out = []
        for i, sample in enumerate(samples):
            down[i], packets = links.arrived(down[i], tick)
            loop = links.sums_anew(loops[i]) if packets else loops[i]
            loops[i], f_m, f = tick_(loop, number, now_ns, sample, packets, self.p.loops[i])
            devices[i], _, _ = device_(devices[i], forces[i], f, self.p.devices[i])
            out.append((sample.x, sample.xd, f_m))
        self.s = LoopState(tuple(loops), tuple(devices), server, tuple(up), tuple(down))
        return out


def _with_paces(s: LoopState, lines: list[links.LinkTimes]) -> LoopState:
    """Return both ends with playouts whose clocks have settled."""

    def settled(end: Any, pace: Pace) -> Any:
        playout = end.arrivals.playout
        stored = add(playout, zero(playout.undelivered), 0.0, STORE_S)
        return end._replace(arrivals=end.arrivals._replace(playout=stored._replace(pace=pace)))

    loops, guests = list(s.loops), list(s.server.guests)
    for i, line in enumerate(lines):
        up, down = settled_paces(line)
        loops[i] = settled(loops[i], down)
        for port in line.ports:
            guests[port] = settled(guests[port], up)
    return s._replace(loops=tuple(loops), server=s.server._replace(guests=tuple(guests)))


def settled_paces(line: links.LinkTimes) -> tuple[Pace, Pace]:
    """Return a user's settled clocks where a hyperperiod begins: at server and device."""
    up = _settled(line.frame, line.delay_up % line.frame.period, line.serve, line.tick_s)
    down = line.serve, line.delay_down % line.serve.period, links.Times(1, 0)
    return up, _settled(*down, line.tick_s)


@functools.lru_cache(maxsize=4096)
def _settled(sent: links.Times, delay: int, steps: links.Times, tick_s: float) -> Pace:
    """Return the clock of a receiver that steps at its times; delay in ticks."""
    ticks, pace = math.lcm(sent.period, steps.period), RESTING_PACE
    arrival = (sent.phase + delay) % sent.period
    for look in range(steps.phase, ticks * math.ceil(SETTLED_S / (ticks * tick_s)), steps.period):
        while arrival <= look:
            pace = pace_arrive(pace, sent.period * tick_s)
            arrival += sent.period
        if arrival >= sent.period:
            pace, _, _ = pace_step(pace, steps.period * tick_s)
    return pace
