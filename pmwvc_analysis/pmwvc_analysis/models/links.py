# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Links with a constant delay: when packets are sent and read, and which of them are under way.

Who reads takes the newest packet that has arrived: the last one sent ``delay`` ticks ago or
earlier. Only packets that will still be read are states; until then they are shifted from one
hyperperiod to the next.
"""

import math
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from pmwvc_core.errors import PmwvcError
from pmwvc_core.frame.schedule import AT_ONCE, LIVE
from pmwvc_core.numeric import Value
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.transport.packet import WavePacket

LONGEST = 20000  # ticks of a hyperperiod
AMPLE_J = 1e3  # a frame: more than any wave of the model needs, so the account never binds
SIGNALS = ("wave", "position")  # of a packet, as far as controllers read them


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
        self.packets: dict[int, WavePacket] = {}
        self._under_way: deque[tuple[int, WavePacket]] = deque()
        self._newest: WavePacket | None = None
        self.relay: Callable[[Packet], Packet] | None = None

    def send(self, tick: int, packet: WavePacket | None) -> None:
        """Put a packet in, or what the relay makes of it."""
        if packet is None:
            return
        if self.relay is not None:
            packet.wave, packet.position = self.relay((packet.wave, packet.position))
        self.packets[tick] = packet
        self._under_way.append((tick + self._delay, packet))

    def collect(self, tick: int) -> list[WavePacket]:
        """Return the packets that have arrived. What their sums add to those of the packet before
        is the wave, and energy for whatever a playout does with it.
        """
        arrived: list[WavePacket] = []
        integral: Value = 0.0
        energy = 0.0
        if self._newest is not None:
            self._newest.integral, self._newest.energy = integral, energy
        while self._under_way and self._under_way[0][0] <= tick:
            _, packet = self._under_way.popleft()
            packet.integral = integral = integral + packet.wave * packet.period
            packet.energy = energy = energy + AMPLE_J
            arrived.append(packet)
            self._newest = packet
        return arrived

    def ages(self) -> list[int]:
        """Return how old packets are when they are read [ticks]."""
        return [look - self._sent.last(look - self._delay) for look in self._looks]
