# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Links with a constant delay, as the values under way at the start of a hyperperiod.

Who reads takes the newest packet that has arrived: the last one sent ``delay`` ticks ago or
earlier. Only packets that will still be read are states.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from pmwvc_core.numeric import Array
from pmwvc_core.params import LinkParams


class Times(NamedTuple):
    """A clock that strikes once in ``period`` ticks, also at tick ``phase``."""

    period: int
    phase: int

    def due(self, tick: int) -> bool:
        return tick % self.period == self.phase % self.period

    def last(self, tick: int) -> int:
        return max(at for at in range(tick, tick - self.period, -1) if self.due(at))


class Channel:
    """One direction of a link.

    Parameters
    ----------
    sent, read
        When packets are sent and when the receiver looks.
    delay
        Age of a packet at arrival [ticks].
    ticks
        Length of the hyperperiod.
    signals
        Names of the values in a packet.

    Attributes
    ----------
    relay
        Where the link is cut: takes what is sent, returns what comes in instead.
    """

    def __init__(
        self, sent: Times, read: Times, *, delay: int, ticks: int, signals: tuple[str, ...]
    ) -> None:
        self._sent, self._delay, self._ticks = sent, delay, ticks
        self._past = self._needed(read)
        self._width = len(signals)
        self.names = tuple(f"{name}[{past}]" for past in self._past for name in signals)
        self._packets: dict[int, list[Array]] = {}
        self.relay: Callable[[list[Array]], list[Array]] | None = None

    def _needed(self, read: Times) -> list[int]:
        """Return when those packets were sent that are under way at tick 0 and still count."""
        looks = range(read.phase, self._ticks, read.period)
        found = {past for look in looks if (past := self._sent.last(look - self._delay)) < 0}
        for past in list(found):
            found.update(range(past, 0, self._ticks))  # they grow old before they are read
        return sorted(found)

    @property
    def state(self) -> list[Array]:
        """One row per name: the packets under way at the end of the hyperperiod."""
        return [row for past in self._past for row in self._packets[past + self._ticks]]

    @state.setter
    def state(self, rows: list[Array]) -> None:
        groups = zip(*[iter(rows)] * self._width, strict=True)
        self._packets = {past: list(group) for past, group in zip(self._past, groups, strict=True)}

    def send(self, tick: int, packet: list[Array]) -> None:
        """Put a packet in, or what the relay makes of it."""
        self._packets[tick] = packet if self.relay is None else self.relay(packet)

    def take(self, tick: int) -> list[Array]:
        """Return the newest packet that has arrived."""
        return self._packets[self._sent.last(tick - self._delay)]

    def ages(self, read: Times) -> list[int]:
        """Return how old packets are when they are read [ticks]."""
        looks = range(read.phase, self._ticks, read.period)
        return [look - self._sent.last(look - self._delay) for look in looks]

    def steady(self, packet: list[Array], slope: list[Array]) -> list[Array]:
        """Return the states when packets are ``packet + slope tick``."""
        return [
            value + rise * past
            for past in self._past
            for value, rise in zip(packet, slope, strict=True)
        ]


def delay_ticks(params: LinkParams, *, tick_s: float, live: bool) -> int:
    """Return after how many ticks a receiver sees a packet; live never at the tick of sending."""
    ticks = math.ceil(params.delay_s / tick_s - 1e-6)
    return max(ticks, int(live))
