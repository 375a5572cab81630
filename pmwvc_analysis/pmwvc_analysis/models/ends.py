# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The two ends of a link, each by itself, as the simulator steps them: a user's force loop with
its device; the server with all avatars. No limits and no brakes act, contacts touch all the time.

What comes in are packets at the times of the links: zeros until an end is at rest. They have sums
from zero on and energy for whatever a playout does with a wave. The clocks of the playouts do not
depend on signals (:mod:`pmwvc_core.law.channel.pace`). Where frames and steps are not equally
long, segments come early and late in turn; the lag that follows them comes to one course around
the hyperperiod, whatever the beginning was, and the model holds for that.

Equations: docs/theory.md 15.3.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

from pmwvc_analysis.models.links import LinkTimes, LinkWay
from pmwvc_analysis.models.variation import (
    AMPLE_J,
    server_at_rest,
    settled_pace,
    sums_anew,
    user_at_rest,
    with_pace,
)
from pmwvc_core.controllers.library import record_of
from pmwvc_core.law.channel.pace import Pace
from pmwvc_core.law.channel.packet import Packet, no_packet
from pmwvc_core.law.server.contacts import offset_of
from pmwvc_core.law.server_step import server_step
from pmwvc_core.law.user_tick import Sample, begin, send, user_tick
from pmwvc_core.law.vectors import Vector, plus, scaled
from pmwvc_core.plant.device import device_step
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.unrolled import unrolled

PERIODS = 4  # until an end that was given packets has answered
Signals = tuple[Vector, Vector, Vector]  # wave, position, extra: of a packet what is read


class Slot(NamedTuple):
    """A packet of a hyperperiod: its way, by number, and which of that way's it is."""

    way: int
    packet: int


Came = dict[Slot, Signals]
Went = tuple[dict[Slot, Packet], tuple[Vector, ...]]


class End(ABC):
    """One end, brought to rest up to tick 0.

    ``s`` and ``p`` are state and parameters; ``ways`` bring packets with so many ``extra`` signals
    beside wave and position; ``ticks`` are those of the hyperperiod, ``dof`` the model's axes.
    """

    name: str

    def __init__(
        self,
        scenario: Scenario,
        made: tuple[Any, Any],
        ways: Sequence[LinkWay],
        extra: int,
        ticks: int,
        dof: int,
    ) -> None:
        self.scenario, self.tick_s = scenario, scenario.tick_s
        self.ways, self.ticks, self.dof = ways, ticks, dof
        self.s, self.p = made
        self.nothing: Signals = (0.0,) * self.dof, (0.0,) * self.dof, (0.0,) * extra
        paces = [settled_pace(way, self.tick_s) for way in ways] if scenario.strict else []
        store_s = max((pace.store_s for pace in paces), default=0.0)
        steps = PERIODS * max(scenario.period_ticks, *(u.master.rate_drop for u in scenario.users))
        to_rest = -(-steps // self.ticks) * self.ticks
        played = 0
        if paces:  # what was in store before the clocks are set is played
            played = -(-(2 * steps + round(store_s / self.tick_s)) // self.ticks) * self.ticks
        self.start = -to_rest - played
        for tick in range(self.start, 0):
            if paces and tick == -played:
                self.set_paces(paces, store_s + self.tick_s)
            self.step(tick, {}, self.nothing[0])

    @abstractmethod
    def step(self, tick: int, came: Came, force: Vector) -> Went:
        """Go one tick on with signals of packets that come in, zeros where none are given, and a
        hand's force; return packets sent, and x, xd and f of a device.
        """

    @abstractmethod
    def set_paces(self, paces: Sequence[Pace], store_s: float) -> None:
        """Set the clocks of the playouts, with so much of zeros in store."""

    def followed(self, s: Any) -> Any:
        """Return a state with what follows from other numbers of it."""
        return s

    def arrived(self, number: int, look: int, came: Came, echo: int = 0) -> list[Packet]:
        """Return the packets of a way that are new at a look, each the answer to packet ``echo``:
        what is linear needs one that is remembered.
        """
        way, packets = self.ways[number], list[Packet]()
        period_s, first = (
            way.sent.period * self.tick_s,
            way.arrivals(way.looked.phase, self.ticks)[0],
        )
        for tick in way.arrivals(look):
            count = 1 + (tick - self.start) // way.sent.period
            slot = Slot(number, (tick - first) // way.sent.period)
            wave, position, extra = came.get(slot, self.nothing)
            integral = scaled(wave, period_s)
            if packets:
                integral = plus(packets[-1].integral, integral)
            packet = no_packet(wave, extra)._replace(
                number=count,
                sent_ns=count * round(period_s * 1e9),
                period_s=period_s,
                integral=integral,
                energy_j=AMPLE_J * (1 + len(packets)),
                position=position,
                echo=echo,
                fresh=count == 1,
            )
            if count > 0:
                packets.append(packet)
        return packets

    def now_ns(self, tick: int) -> int:
        """Return the time of a tick since the start."""
        return (tick - self.start) * round(self.tick_s * 1e9)


class UserState(NamedTuple):
    """A force loop and the device that it moves."""

    loop: Any
    device: Any


class PerturbedUser(End):
    """The force loop and the device of a user (the only one of the scenarios)."""

    def __init__(
        self, scenario: Scenario, ticks: int, dof: int, times: LinkTimes, fed: bool
    ) -> None:
        self.sends, self.name = times.up.sent, scenario.users[0].name
        laws = (send, begin, user_tick, device_step)
        self._send, self._begin, self._tick, self._device = (unrolled(law, dof) for law in laws)
        s, p = user_at_rest(scenario, dof, times.taken.phase, fed)
        down = record_of(scenario.controller).extra(dof)[1]
        super().__init__(scenario, (UserState(*s), p), [times.down], down, ticks, dof)

    def step(self, tick: int, came: Came, force: Vector) -> Went:
        """Go one tick on; see :meth:`End.step`."""
        (loop, device), (p, of_device), sent = self.s, self.p, dict[Slot, Packet]()
        number, now_ns = tick - self.start, self.now_ns(tick)
        sample = Sample(device.read_x, device.read_xd, True, now_ns, False)
        if self.sends.due(tick):
            loop, packet, _ = self._send(loop, now_ns, sample, False, p)
            loop = self._begin(loop, number, p)
            sent[Slot(0, tick // self.sends.period)] = packet
        packets = self.arrived(0, tick, came, loop.packing.number)
        loop = sums_anew(loop) if packets else loop
        loop, f_m, f = self._tick(loop, number, now_ns, sample, packets, p)
        device, _, _ = self._device(device, force, f, of_device)
        self.s = UserState(loop, device)
        return sent, (sample.x, sample.xd, f_m)

    def set_paces(self, paces: Sequence[Pace], store_s: float) -> None:
        """Set the clock of the playout."""
        self.s = self.s._replace(loop=with_pace(self.s.loop, paces[0], store_s))


class PerturbedServer(End):
    """The server with all avatars."""

    def __init__(
        self, scenario: Scenario, ticks: int, dof: int, times: Sequence[LinkTimes]
    ) -> None:
        self.serve, self.name = times[0].up.looked, "server"
        self._step = unrolled(server_step, dof)
        up, made = record_of(scenario.controller).extra(dof)[0], server_at_rest(scenario, dof)
        super().__init__(scenario, made, [each.up for each in times], up, ticks, dof)

    def step(self, tick: int, came: Came, force: Vector) -> Went:
        """Go one tick on; see :meth:`End.step`."""
        if not self.serve.due(tick):
            return {}, ()
        packets = tuple(self.arrived(way, tick, came) for way in range(len(self.ways)))
        s = self.s._replace(guests=tuple(map(sums_anew, self.s.guests)))
        self.s, answers = self._step(s, self.now_ns(tick), packets, 0.0, self.p)
        sent = tick // self.serve.period
        return {Slot(user, sent): packet for user, (packet, _) in enumerate(answers)}, ()

    def set_paces(self, paces: Sequence[Pace], store_s: float) -> None:
        """Set the clocks of the playouts."""
        pairs = zip(self.s.guests, paces, strict=True)
        self.s = self.s._replace(guests=tuple(with_pace(s, pace, store_s) for s, pace in pairs))

    def followed(self, s: Any) -> Any:
        """Put avatars where contacts and object are."""
        environment = s.environment
        ports, body = list(environment.ports), environment.body
        if self.scenario.coupling.black_box:
            at = body.environment.body
            body = body._replace(x=at.x, xd=at.xd)
        x_s = [plus(body.x, offset_of(port.avatar.contact)) for port in ports]
        ports = [port._replace(x_s=x) for port, x in zip(ports, x_s, strict=True)]
        return s._replace(environment=environment._replace(ports=tuple(ports), body=body))
