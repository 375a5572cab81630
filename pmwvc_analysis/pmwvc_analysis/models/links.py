# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""When ends step, send and look, and links with a constant delay as shifts of what is sent.

Over a hyperperiod of N ticks an end sends packets at the slots 0, 1, ... and looks at others. One
that arrives at tick a was sent at a - delay: in slot ((a - delay) mod N)/period of so many
hyperperiods ago. What comes in at an end repeats with the delay modulo the sender's period; all
else of a delay is a number of hyperperiods.
"""

import math
from typing import NamedTuple

from pmwvc_core.frame import AT_ONCE, LIVE
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User


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


EVERY_TICK = Times(1, 0)


class LinkWay(NamedTuple):
    """A link in one direction."""

    sent: Times
    looked: Times  # when the receiver looks
    delay: int  # [ticks]

    def ages(self, ticks: int) -> list[int]:
        """Return how old the newest packet is at each look, over so many ticks [ticks]."""
        of, looks = self.sent, range(self.looked.phase, self.looked.phase + ticks, self.looked[0])
        return [self.delay + (look - self.delay - of.phase) % of.period for look in looks]

    @property
    def pattern(self) -> "LinkWay":
        """The shortest delay with the same arrivals at the receiver."""
        return self._replace(delay=self.delay % self.sent.period)

    def arrivals(self, look: int, ticks: int = 0) -> range:
        """Return when packets arrive that are new at a look, and at those of more ticks."""
        first = look - self.looked.period + 1
        first += (self.sent.phase + self.delay - first) % self.sent.period
        return range(first, look + max(ticks - self.looked.period, 0) + 1, self.sent.period)

    def wires(self, ticks: int) -> list[tuple[int, int]]:
        """Return for every packet that comes in over a hyperperiod its slot at the sender, and how
        many hyperperiods ago that was.
        """
        sent = [tick - self.delay for tick in self.arrivals(self.looked.phase, ticks)]
        return [(tick % ticks // self.sent.period, -(tick // ticks)) for tick in sent]


class LinkTimes(NamedTuple):
    """When a user's end and the server talk to each other."""

    up: LinkWay
    down: LinkWay
    taken: Times  # when the user's end takes an answer into its port


def link_times(user: User, scenario: Scenario, *, live: bool) -> LinkTimes:
    """Return when packets of a user and answers to it are sent and looked at."""
    schedule, frame = LIVE if live else AT_ONCE, user.master.rate_drop
    period, tick_s = scenario.period_ticks, scenario.tick_s
    answer = schedule.answer_tick(tick_s=user.master.tick_s, rate_drop=frame)
    serve = Times(period, schedule.server_tick(tick_s=tick_s, period_ticks=period))
    up, down = (
        delay_ticks(link, tick_s=tick_s, live=live) for link in (user.link_up, user.link_down)
    )
    sends = Times(frame, 0)
    return LinkTimes(
        LinkWay(sends, serve, up), LinkWay(serve, EVERY_TICK, down), Times(frame, answer)
    )
