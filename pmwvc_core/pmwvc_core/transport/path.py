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
from typing import NamedTuple

from pmwvc_core.transport.clock_line import Least, latest_line
from pmwvc_core.transport.packet import WavePacket

WINDOW_NS = 1_000_000_000
MOST_WINDOWS = 60  # a minute shows a drift of 1 ppm behind jitter of 0.06 ms
JITTER_PACKETS = 16.0
LONGEST_ROUND_TRIP_NS = 600 * 10**9
HOLD_NS = 1_000_000  # by which two clocks measure the same hold differently, at most


class Way:
    """The passages of one direction in one window [ns], and its jitter, which goes on from the
    window before.
    """

    def __init__(self, before: "Way | None" = None) -> None:
        self.jitter_ns: float = before.jitter_ns if before else 0.0
        self._last: int | None = before._last if before else None
        self.packets = self.total = self.most = 0
        self.least = Least(0, 0)

    def add(self, at_ns: int, passage_ns: int) -> None:
        """Take a passage, seen at an instant of this end's clock."""
        if self._last is not None:
            self.jitter_ns += (abs(passage_ns - self._last) - self.jitter_ns) / JITTER_PACKETS
        self._last = passage_ns
        if not self.packets or passage_ns < self.least.passage_ns:
            self.least = Least(at_ns, passage_ns)
        self.most = max(self.most, passage_ns) if self.packets else passage_ns
        self.packets += 1
        self.total += passage_ns


class Window(NamedTuple):
    """The passages of both directions in one window, which began at ``start_ns``."""

    start_ns: int
    out: Way
    into: Way


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


class Path:
    """Passages of packets and echoes at one end of a path."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget everything: the other end has another clock."""
        self.windows: list[Window] = []  # whole ones; a new list each time, for other threads
        self.out, self.into = Way(), Way()
        self._start_ns = 0
        self._echoed = 0

    def add(self, packet: WavePacket, came_ns: int) -> None:
        """Take a packet that came in at this instant of this end's clock."""
        if came_ns - self._start_ns >= WINDOW_NS:
            if self.out.packets and self.into.packets:
                window = Window(self._start_ns, self.out, self.into)
                self.windows = [*self.windows[1 - MOST_WINDOWS :], window]
            self.out, self.into, self._start_ns = Way(self.out), Way(self.into), came_ns
        into_ns = came_ns - packet.sent_ns
        self.into.add(came_ns, into_ns)
        if packet.echo_seq > self._echoed:
            self._echoed = packet.echo_seq
            out_ns = packet.sent_ns - packet.echo_hold_ns - packet.echo_sent_ns
            if -HOLD_NS <= out_ns + into_ns <= LONGEST_ROUND_TRIP_NS:
                self.out.add(packet.echo_sent_ns, out_ns)

    def estimate(self) -> PathEstimate | None:
        """Return what is known; None before a whole window with both directions, and where the
        least round trip is below zero: the other end's times are those of no clock.
        """
        windows = self.windows
        found = latest_line([(window.out.least, window.into.least) for window in windows])
        if found is None:
            return None
        line, before = found  # the path changed since those before
        last = windows[-1]
        theta_ns = line.theta_ns(last.start_ns + WINDOW_NS // 2)

        def least_ns(seen: list[Least], sign: int) -> float:  # passages out hold theta, in less it
            return min(each.passage_ns - sign * line.theta_ns(each.at_ns) for each in seen)

        def one_way(least_ns: float, seen: Way, shift_ns: float, jitter_ns: float) -> OneWay:
            mean_ns = seen.total / seen.packets + shift_ns
            return OneWay(
                least_ns * 1e-9, mean_ns * 1e-9, (seen.most + shift_ns) * 1e-9, jitter_ns * 1e-9
            )

        out_ns = least_ns([window.out.least for window in windows[before:]], 1)
        into_ns = least_ns([window.into.least for window in windows[before:]], -1)
        open_s, round_trip_s = line.open_ns * 1e-9, (out_ns + into_ns) * 1e-9
        if round_trip_s < -2.0 * open_s:
            return None
        return PathEstimate(
            out=one_way(out_ns, last.out, -theta_ns, self.out.jitter_ns),
            into=one_way(into_ns, last.into, theta_ns, self.into.jitter_ns),
            open_s=open_s,
            one_clock=line.one_clock,
            offset_s=theta_ns * 1e-9,
            drift_ppm=line.rate * 1e6,
            drift_open_ppm=line.rate_open * 1e6,
            round_trip_s=round_trip_s,
        )
