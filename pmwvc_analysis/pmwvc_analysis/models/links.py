# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Links with a constant delay: when packets are sent and read, and which of them are under way.

Who reads takes the newest packet that has arrived: the last one sent ``delay`` ticks ago or
earlier. Only packets that will still be read are states; until then they are shifted from one
hyperperiod to the next.
"""

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pmwvc_analysis.models.elements import repeated
from pmwvc_core.controllers.library import has_waves, record_of
from pmwvc_core.errors import PmwvcError
from pmwvc_core.frame.schedule import AT_ONCE, LIVE
from pmwvc_core.law.channel.arrivals import StrictArrivals
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.vectors import plus, scaled, zero
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User

LONGEST = 20000  # ticks of a hyperperiod
AMPLE_J = 1e3  # a frame: more than any wave of the model needs, so the account never binds
WAVE, POSITION, EXTRA = "wave", "position", "extra"
SIGNALS = (WAVE, POSITION, EXTRA)  # of a packet, as far as controllers read them
CUT = (WAVE, POSITION)  # those that a cut link gives back


def size_of(scenario: Scenario, way: str, signal: str, dof: int) -> int:
    """Return how many numbers a signal of the packets up or down has."""
    return record_of(scenario.controller).extra(dof)[way == "down"] if signal == EXTRA else dof


def hyperperiod_ticks(scenario: Scenario) -> int:
    """Return the least common multiple of all frames and the server's period [ticks]."""
    return math.lcm(scenario.period_ticks, *(user.master.rate_drop for user in scenario.users))


def modelled_ticks(scenario: Scenario) -> int:
    """Return the length of the hyperperiod, where it is short enough for a model [ticks].

    Raises
    ------
    PmwvcError
        If it is too long.
    """
    ticks = hyperperiod_ticks(scenario)
    if ticks > LONGEST:
        raise PmwvcError(
            f"{scenario.name}: frames and server period fit together only after {ticks} ticks, "
            f"more than {LONGEST}; choose rate_drop and period_s with common factors"
        )
    return ticks


def delay_ticks(params: LinkParams, *, tick_s: float, live: bool) -> int:
    """Return the delay of a link in whole ticks, rounded up: receivers look at their ticks.

    A live packet takes at least something, so it is never there at the tick it was sent.
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


def times_of(user: User, scenario: Scenario, *, live: bool) -> tuple[Times, Times, Times]:
    """Return when a user sends and when it takes an answer, and when the server steps."""
    schedule, period, frame = (
        LIVE if live else AT_ONCE,
        scenario.period_ticks,
        user.master.rate_drop,
    )
    answer = schedule.answer_tick(tick_s=user.master.tick_s, rate_drop=frame)
    serve = schedule.server_tick(tick_s=scenario.tick_s, period_ticks=period)
    return Times(frame, 0), Times(frame, answer), Times(period, serve)


class Link:
    """One direction of a link.

    Parameters
    ----------
    sent, read
        When packets are sent and when the receiver looks.
    delay
        Age of a packet at arrival [ticks].
    ticks
        Length of the hyperperiod.
    """

    def __init__(self, sent: Times, read: Times, *, delay: int, ticks: int) -> None:
        self._sent, self._delay = sent, delay
        self._looks = range(read.phase, ticks, read.period)
        looked_at = {  # all that came since the last look
            at
            for look in self._looks
            for at in range(sent.last(look - delay), look - read.period - delay, -sent.period)
            if at < 0
        }
        # When those packets were sent that are under way at tick 0 and still count.
        self.past = sorted({at for past in looked_at for at in range(past, 0, ticks)})
        # Those sent, by their tick: what their signals say is a state until it is read.
        self.packets: dict[int, Packet] = {}
        self._under_way: deque[tuple[int, int]] = deque()  # arrival, sending
        self._settled: list[tuple[int, int, Packet]] = []
        self._begun = False
        # Where the link is cut: takes what is sent, returns what comes in instead.
        self.relay: Callable[[Packet], Packet] | None = None

    def settle(self) -> None:
        """Take what is under way now as that of every beginning of the hyperperiod."""
        self._settled = [(arrival, at, self.packets[at]) for arrival, at in self._under_way]

    def begin(self, columns: int, units: Mapping[tuple[int, str, int], Any]) -> None:
        """Begin the hyperperiod again for so many columns, with signals of packets under way by
        the tick of their sending, signal and axis.
        """
        self._under_way = deque((arrival, at) for arrival, at, _ in self._settled)
        for _, at, packet in self._settled:
            packet = repeated(packet, columns)
            for signal in SIGNALS:
                values = getattr(packet, signal)
                given = [units.get((at, signal, axis), 0.0) for axis in range(len(values))]
                packet = packet._replace(**{signal: tuple(given)})
            self.packets[at] = packet

    def send(self, tick: int, packet: Packet) -> None:
        """Put a packet in, or what the relay makes of it."""
        if self.relay is not None:
            packet = self.relay(packet)
        self.packets[tick] = packet
        self._under_way.append((tick + self._delay, tick))

    def collect(self, tick: int) -> list[Packet]:
        """Return the packets that have arrived. What their sums add to those of the packet before
        is the wave, and energy for whatever a playout does with it: the receiver's own sums are
        zero when they come.
        """
        arrived: list[Packet] = []
        energy_j = 0.0
        while self._under_way and self._under_way[0][0] <= tick:
            packet = self.packets[self._under_way.popleft()[1]]
            energy_j += AMPLE_J
            integral = scaled(packet.wave, packet.period_s)
            if arrived:
                integral = plus(arrived[-1].integral, integral)
            fresh = not self._begun
            self._begun = True
            packet = packet._replace(integral=integral, energy_j=energy_j, fresh=fresh)
            arrived.append(packet)
        return arrived

    def ages(self) -> list[int]:
        """Return how old packets are when they are read [ticks]."""
        return [look - self._sent.last(look - self._delay) for look in self._looks]


class Line(NamedTuple):
    """When a user's end and the server talk to each other."""

    user: User
    waves: bool  # whether its controller has waves
    ports: tuple[int, ...]  # numbers of those at the server: several for equal users
    frame: Times  # when it sends
    answer: Times  # when it takes an answer
    serve: Times  # when the server steps
    delay_down: int  # from the server [ticks]
    delay: int  # both ways together [ticks]
    up: Link
    down: Link
    tick_s: float

    @property
    def name(self) -> str:
        """Of the user."""
        return self.user.name


def line_of(scenario: Scenario, index: int, ports: tuple[int, ...], *, live: bool) -> Line:
    """Return the line of a user by its number, from 0."""
    user, tick_s = scenario.users[index], scenario.tick_s
    frame, answer, serve = times_of(user, scenario, live=live)
    up = delay_ticks(user.link_up, tick_s=tick_s, live=live)
    down = delay_ticks(user.link_down, tick_s=tick_s, live=live)
    ticks = hyperperiod_ticks(scenario)
    return Line(
        user,
        has_waves(scenario.controller),
        ports,
        frame,
        answer,
        serve,
        down,
        up + down,
        Link(frame, serve, delay=up, ticks=ticks),
        Link(serve, Times(1, 0), delay=down, ticks=ticks),
        tick_s,
    )


def sums_anew(s: Any) -> Any:
    """Let the sums that a strict receiver believes begin at zero (:meth:`.links.Link.collect`)."""
    arrivals = s.arrivals
    if not isinstance(arrivals, StrictArrivals):
        return s
    counting = arrivals.counting
    counting = counting._replace(integral=zero(counting.integral), energy_j=0.0)
    return s._replace(arrivals=arrivals._replace(counting=counting))
