# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Links with a constant delay: when packets are sent and read, and which of them are under way.

Who reads takes the newest packet that has arrived: the last one sent ``delay`` ticks ago or
earlier. Only packets that will still be read are states; until then they are shifted from one
hyperperiod to the next.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from pmwvc_core.frame.schedule import AT_ONCE, LIVE
from pmwvc_core.numeric import Value
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User

SIGNALS = ("wave", "position")  # of a packet, as far as controllers read them


def hyperperiod_ticks(scenario: Scenario) -> int:
    """Return the least common multiple of all frames and the server's period [ticks]."""
    return math.lcm(scenario.period_ticks, *(user.master.rate_drop for user in scenario.users))


def answer_phase(user: User, *, live: bool) -> int:
    """Return the tick of a frame at which the master takes an answer."""
    master, schedule = user.master, LIVE if live else AT_ONCE
    return schedule.answer_tick(tick_s=master.tick_s, rate_drop=master.rate_drop)


def serve_phase(scenario: Scenario, *, live: bool) -> int:
    """Return the tick of its period at which the server steps."""
    schedule = LIVE if live else AT_ONCE
    return schedule.server_tick(tick_s=scenario.tick_s, period_ticks=scenario.period_ticks)


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


Packet = tuple[Value, ...]  # in the order of SIGNALS


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

    Attributes
    ----------
    past
        When those packets were sent that are under way at tick 0 and still count.
    read
        Those of them that are read in the hyperperiod.
    packets
        Those sent, by their tick.
    relay
        Where the link is cut: takes what is sent, returns what comes in instead.
    """

    def __init__(self, sent: Times, read: Times, *, delay: int, ticks: int) -> None:
        self._sent, self._delay = sent, delay
        self._looks = range(read.phase, ticks, read.period)
        self.read = {at for look in self._looks if (at := sent.last(look - delay)) < 0}
        older = {at for past in self.read for at in range(past, 0, ticks)}
        self.past = sorted(older)
        self.packets: dict[int, Packet] = {}
        self.relay: Callable[[Packet], Packet] | None = None

    def send(self, tick: int, packet: Packet) -> None:
        """Put a packet in, or what the relay makes of it."""
        self.packets[tick] = packet if self.relay is None else self.relay(packet)

    def arrived(self, tick: int) -> Packet | None:
        """Return the packet that arrives at a tick, if one does."""
        at = tick - self._delay
        return self.packets.get(at, (0.0, 0.0)) if self._sent.due(at) else None

    def take(self, tick: int) -> tuple[int, Packet]:
        """Return the newest packet that has arrived, with its number; before the first: zeros."""
        at = self._sent.last(tick - self._delay)
        return at // self._sent.period, self.packets.get(at, (0.0, 0.0))

    def ages(self) -> list[int]:
        """Return how old packets are when they are read [ticks]."""
        return [look - self._sent.last(look - self._delay) for look in self._looks]
