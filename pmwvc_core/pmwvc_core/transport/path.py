# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The path of a user's packets: delay and jitter per direction, as one of its ends sees them.

Every packet brings two passages (:mod:`.clock_line`): its own, and by its echo that of the newest
packet that the other end has got. What they show:

* the least round trip, and how far any packet was above the least delay of its direction: exact,
  whatever the clocks are;
* the division of the least round trip between the directions: exact where both ends read one clock
  (one machine); else a bound, half of it each way, because a constant asymmetric delay looks like
  an offset of the clocks;
* offset and drift of the clocks, within the same bound.

Delays end at the reception by the middleware, before a loop takes the packet. Jitter is that of
RFC 3550 (6.4.1): the running mean, over 16 packets, of |change of passage|.
Time is an argument.
"""

from dataclasses import dataclass
from typing import NamedTuple, Self

from pmwvc_core.state import Stateful
from pmwvc_core.transport.clock_line import ClockLine, Least, latest_line
from pmwvc_core.transport.packet import WavePacket

WINDOW_NS = 1_000_000_000
MOST_WINDOWS = 60  # a minute shows a drift of 1 ppm behind jitter of 0.06 ms
JITTER_PACKETS = 16.0
LONGEST_ROUND_TRIP_NS = 600 * 10**9
HOLD_NS = 1_000_000  # by which two clocks measure the same hold differently, at most


@dataclass(frozen=True, slots=True)
class Passages:
    """The passages of one direction in one window [ns]."""

    packets: int
    total: int
    most: int
    least: Least

    @classmethod
    def of(cls, passages: list[int], at_ns: list[int]) -> Self:
        """Return those of packets, seen at instants of this end's clock."""
        least = min(passages)
        seen = Least(at_ns[passages.index(least)], least)
        return cls(len(passages), sum(passages), max(passages), seen)


class Window(NamedTuple):
    """The passages of both directions in one window, which began at ``start_ns``."""

    start_ns: int
    out: Passages
    into: Passages


@dataclass(frozen=True)
class OneWay:
    """Delay of one direction [s]: the least of the last minute, and of the last whole second."""

    least_s: float
    mean_s: float
    most_s: float
    jitter_s: float


@dataclass(frozen=True)
class PathEstimate:
    """Estimate of a path at one of its ends."""

    out: OneWay  # delays from this end,
    into: OneWay  # and to it: both true within open_s, with opposite signs
    open_s: float  # bound of the division between the directions; 0 where both read one clock
    one_clock: bool  # whether they do
    offset_s: float  # other end's clock less this one's
    drift_ppm: float  # its change,
    drift_open_ppm: float  # and the bound of that
    round_trip_s: float  # sum of both least delays


class Path(Stateful):
    """Passages of packets and echoes at one end of a path."""

    MEMORY = (
        "windows jitter_out_ns jitter_into_ns _out _into _out_at_ns _into_at_ns _start_ns "
        "_last_out _last_into _echoed"
    )

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget everything: the other end has another clock."""
        self.windows: list[Window] = []  # whole ones; a new list each time, for other threads
        self._out: list[int] = []  # passages since the window began,
        self._into: list[int] = []
        self._out_at_ns: list[int] = []  # and when they were seen
        self._into_at_ns: list[int] = []
        self.jitter_out_ns = 0.0
        self.jitter_into_ns = 0.0
        self._start_ns = 0
        self._last_out: int | None = None  # passage
        self._last_into: int | None = None
        self._echoed = 0

    def add(self, packet: WavePacket, came_ns: int) -> None:
        """Take a packet that came in at this instant of this end's clock."""
        if came_ns - self._start_ns >= WINDOW_NS:
            self._close(came_ns)
        sent_ns, before = packet.sent_ns, self._last_into
        self._last_into = into = came_ns - sent_ns
        if before is not None:
            change = abs(into - before)
            self.jitter_into_ns += (change - self.jitter_into_ns) / JITTER_PACKETS
        self._into.append(into)
        self._into_at_ns.append(came_ns)
        if packet.echo_seq > self._echoed:
            self._echoed = packet.echo_seq
            out = sent_ns - packet.echo_hold_ns - packet.echo_sent_ns
            if -HOLD_NS <= out + into <= LONGEST_ROUND_TRIP_NS:
                before, self._last_out = self._last_out, out
                if before is not None:
                    change = abs(out - before)
                    self.jitter_out_ns += (change - self.jitter_out_ns) / JITTER_PACKETS
                self._out.append(out)
                self._out_at_ns.append(packet.echo_sent_ns)

    def estimate(self) -> PathEstimate | None:
        """Return what is known; None before a whole window with both directions, and where the
        least round trip is below zero: the other end's times are those of no clock.
        """
        windows = self.windows
        found = latest_line([(window.out.least, window.into.least) for window in windows])
        if found is None:
            return None
        line, before = found  # the path changed since those before
        estimate = self._estimated(windows[before:], line)
        return estimate if estimate.round_trip_s >= -2.0 * estimate.open_s else None

    def _close(self, now_ns: int) -> None:
        """Put the current window aside and begin one."""
        if self._out and self._into:
            out = Passages.of(self._out, self._out_at_ns)
            window = Window(self._start_ns, out, Passages.of(self._into, self._into_at_ns))
            self.windows = [*self.windows[1 - MOST_WINDOWS :], window]
        for each in (self._out, self._into, self._out_at_ns, self._into_at_ns):
            each.clear()
        self._start_ns = now_ns

    def _estimated(self, windows: list[Window], line: ClockLine) -> PathEstimate:
        last = windows[-1]
        theta_ns = line.theta_ns(last.start_ns + WINDOW_NS // 2)

        def one_way(least_ns: float, seen: Passages, shift_ns: float, jitter_ns: float) -> OneWay:
            mean_ns = seen.total / seen.packets + shift_ns
            most_ns = seen.most + shift_ns
            return OneWay(least_ns * 1e-9, mean_ns * 1e-9, most_ns * 1e-9, jitter_ns * 1e-9)

        out = [window.out.least for window in windows]
        into = [window.into.least for window in windows]
        least_out = min(each.passage_ns - line.theta_ns(each.at_ns) for each in out)
        least_into = min(each.passage_ns + line.theta_ns(each.at_ns) for each in into)
        return PathEstimate(
            out=one_way(least_out, last.out, -theta_ns, self.jitter_out_ns),
            into=one_way(least_into, last.into, theta_ns, self.jitter_into_ns),
            open_s=line.open_ns * 1e-9,
            one_clock=line.one_clock,
            offset_s=theta_ns * 1e-9,
            drift_ppm=line.rate * 1e6,
            drift_open_ppm=line.rate_open * 1e6,
            round_trip_s=(least_out + least_into) * 1e-9,
        )
