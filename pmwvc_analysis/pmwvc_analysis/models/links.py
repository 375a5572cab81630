# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""When ends step, send and read, and links with a constant delay.

Who reads takes the newest packet that has arrived: the last one sent ``delay`` ticks ago or
earlier. Packets under way are part of the state.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.frame import AT_ONCE, LIVE
from pmwvc_core.law.channel.arrivals import StrictArrivals
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.vectors import plus, scaled, zero
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User

AMPLE_J = 1e3  # a frame: more than any wave of the model needs, so the account never binds
SIGNALS = ("wave", "position", "extra")  # of a packet, as far as controllers read them


def hyperperiod_ticks(scenario: Scenario) -> int:
    """Return the least common multiple of all frames and the server's period [ticks]."""
    return math.lcm(scenario.period_ticks, *(user.master.rate_drop for user in scenario.users))


def delay_ticks(params: LinkParams, *, tick_s: float, live: bool) -> int:
    """Return the delay of a link in whole ticks, rounded up: receivers look at their ticks. Live,
    a packet is never there at the tick it was sent.
    """
    ticks = -(-round(params.delay_s * 1e9) // round(tick_s * 1e9))
    return max(ticks, 1) if live else ticks


class Times(NamedTuple):
    """Ticks ``phase``, ``phase + period``, ... at which something happens."""

    period: int
    phase: int

    def due(self, tick: int) -> bool:
        """Tell whether it happens at this tick."""
        return (tick - self.phase) % self.period == 0

    def last(self, tick: int) -> int:
        """Return when it happened last, this tick included."""
        return tick - (tick - self.phase) % self.period

    def ages(self, sent: "Times", delay: int, ticks: int) -> list[int]:
        """Return how old packets are when they are looked at, over so many ticks [ticks]."""
        looks = range(self.phase, self.phase + ticks, self.period)
        return [look - sent.last(look - delay) for look in looks]


def times_of(user: User, scenario: Scenario, *, live: bool) -> tuple[Times, Times, Times]:
    """Return when a user sends and when it takes an answer, and when the server steps."""
    schedule = LIVE if live else AT_ONCE
    period, frame = scenario.period_ticks, user.master.rate_drop
    answer = schedule.answer_tick(tick_s=user.master.tick_s, rate_drop=frame)
    serve = schedule.server_tick(tick_s=scenario.tick_s, period_ticks=period)
    return Times(frame, 0), Times(frame, answer), Times(period, serve)


class LinkTimes(NamedTuple):
    """When a user's end and the server talk to each other."""

    user: User
    ports: tuple[int, ...]  # numbers of those at the server: several for equal users
    frame: Times  # when it sends
    answer: Times  # when it takes an answer
    serve: Times  # when the server steps
    delay_up: int  # to the server [ticks]
    delay_down: int  # from the server [ticks]
    tick_s: float


def line_of(user: User, scenario: Scenario, ports: tuple[int, ...], *, live: bool) -> LinkTimes:
    """Return the line of a user."""
    up, down = (
        delay_ticks(link, tick_s=scenario.tick_s, live=live)
        for link in (user.link_up, user.link_down)
    )
    return LinkTimes(user, ports, *times_of(user, scenario, live=live), up, down, scenario.tick_s)


class PacketUnderWay(NamedTuple):
    """A packet under way."""

    tick: int  # of its sending
    arrives: int
    packet: Packet


UnderWay = tuple[PacketUnderWay, ...]


def arrived(way: UnderWay, tick: int) -> tuple[UnderWay, list[Packet]]:
    """Return what is under way still, and the packets that have arrived: with sums from zero on
    (:func:`sums_anew`), and energy for whatever a playout does with a wave.
    """
    packets: list[Packet] = []
    while way and way[0].arrives <= tick:
        packet, way = way[0].packet, way[1:]
        integral = scaled(packet.wave, packet.period_s)
        if packets:
            integral = plus(packets[-1].integral, integral)
        energy_j = AMPLE_J * (1 + len(packets))
        first = packet.number == 1
        packets.append(packet._replace(integral=integral, energy_j=energy_j, fresh=first))
    return way, packets


def sums_anew(s: Any) -> Any:
    """Let the sums that a strict receiver believes begin at zero."""
    arrivals = s.arrivals
    if not isinstance(arrivals, StrictArrivals):
        return s
    counting = arrivals.counting
    counting = counting._replace(integral=zero(counting.integral), energy_j=0.0)
    return s._replace(arrivals=arrivals._replace(counting=counting))
