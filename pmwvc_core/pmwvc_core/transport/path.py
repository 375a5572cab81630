# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The path of a user's packets, as one of its ends sees it: delay and jitter per direction, offset
and drift of the clocks.

A passage is the arrival by the receiver's clock less the departure by the sender's. Every packet
brings two: its own, and by its echo one of the other way. With theta = the other end's clock less
this one's and delays d_out, d_in >= 0::

    out = d_out + theta        in = d_in - theta

The least round trip is exact. Where both ends read one clock its parts are; else -min(in) <= theta
<= min(out), the middle is taken, half the width is the bound.

Over windows theta = (out - in)/2 up to the asymmetry. A window whose least round trip is longer
than the shortest by 2 e has its middle off by e, by what is usual (the median of e), and twice the
median scatter of the middles about a line. The drift is every slope that fits all windows so,
within ``MOST_DRIFT``; where none does, the least delays changed. Jitter: RFC 3550 (6.4.1). Time is
an argument. Equation: docs/theory.md 13.9.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.transport.packet import WavePacket

ONE_CLOCK_NS = 1_000_000_000  # a larger sum of both delays does not decide whether it is one clock
MOST_DRIFT = 500e-6  # of two computers' clocks
FEWEST = 8  # windows that show a drift
READING_NS = 1_000.0  # a clock is read to this
WITHIN_NS = 500_000_000.0  # half a window


class Shortest(NamedTuple):
    """The least passage of a window, and when it was seen on this end's clock [ns]."""

    at_ns: int
    passage_ns: int


class ClockLine(NamedTuple):
    """theta(t) = ``offset_ns`` + ``rate`` (t - ``at_ns``) +- ``open_ns``, t on this end's clock.

    ``rate_open`` is half the width of the interval of drifts that fit; it is within ``open_ns``.
    ``one_clock``: theta = 0 fits, so both ends read the same clock, and nothing is open.
    """

    offset_ns: float
    rate: float
    at_ns: int
    open_ns: float
    rate_open: float
    one_clock: bool

    def theta_ns(self, at_ns: int) -> float:
        """Return theta at an instant of this end's clock [ns]."""
        return self.offset_ns + self.rate * (at_ns - self.at_ns)


def clock_line(out: Sequence[Shortest], into: Sequence[Shortest]) -> ClockLine | None:
    """Return the line through the least passages of windows, either way, ascending in time, at
    least one; None where the least delays changed between them.
    """
    least = [min(each.passage_ns for each in way) for way in (out, into)]
    if min(least) >= 0 and sum(least) < ONE_CLOCK_NS:
        return ClockLine(0.0, 0.0, out[-1].at_ns, 0.0, 0.0, one_clock=True)
    begin_ns = out[0].at_ns
    # floats do not hold the clocks of years
    reference = (out[0].passage_ns - into[0].passage_ns) // 2
    times_out, times_into = (
        np.array([each.at_ns - begin_ns for each in way], dtype=float) for way in (out, into)
    )
    rising = np.array([each.passage_ns - reference for each in out], dtype=float)
    falling = np.array([each.passage_ns + reference for each in into], dtype=float)
    times = (times_out + times_into) / 2.0
    rate = rate_open = 0.0
    for _ in range(2):  # theta moves between the two instants of a window, by the drift
        apart = rate * (times_out - times_into) / 2.0
        up, down = rising - apart, falling - apart
        excess = (up + down) / 2.0
        excess -= excess.min()
        middles = (up - down) / 2.0
        usual = np.median(excess) + _scatter(times, middles) + READING_NS
        slopes = _slopes(times, middles, excess + usual)
        if slopes is None:
            return None
        rate, rate_open = (slopes[1] + slopes[0]) / 2.0, (slopes[1] - slopes[0]) / 2.0
    centre = float(times.mean())
    high = float((rising - rate * (times_out - centre)).min())
    low = float((-falling - rate * (times_into - centre)).max())
    drifted = rate_open * (float(np.ptp(times)) / 2.0 + WITHIN_NS)
    offset_ns = reference + (high + low) / 2.0
    open_ns = max(high - low, 0.0) / 2.0 + drifted + READING_NS
    return ClockLine(
        offset_ns, rate, begin_ns + round(centre), open_ns, rate_open, one_clock=False
    )


def latest_line(windows: Sequence[tuple[Shortest, Shortest]]) -> tuple[ClockLine, int] | None:
    """Return the line through as many last windows as fit, and how many came before."""
    for before in range(len(windows)):
        line = clock_line(*zip(*windows[before:], strict=True))
        if line is not None:
            return line, before
    return None


def _scatter(times: Array, middles: Array) -> float:
    """Return how far middles usually are from a straight line, twice; endless for few of them."""
    if len(times) < FEWEST:
        return np.inf
    centred = times - times.mean()
    rate = float(centred @ middles) / float(centred @ centred)
    return 2.0 * float(np.median(np.abs(middles - middles.mean() - rate * centred)))


def _slopes(times: Array, middles: Array, widths: Array) -> tuple[float, float] | None:
    """Return the least and the greatest slope of lines within all intervals; None without one."""
    earlier, later = np.triu_indices(len(times), 1)
    span = times[later] - times[earlier]
    rise = middles[later] - middles[earlier]
    width = widths[later] + widths[earlier]
    least = float(np.max((rise - width) / span, initial=-MOST_DRIFT))
    most = float(np.min((rise + width) / span, initial=MOST_DRIFT))
    return (least, most) if least <= most else None


WINDOW_NS = 1_000_000_000
MOST_WINDOWS = 60  # a minute shows a drift of 1 ppm behind jitter of 0.06 ms
JITTER_PACKETS = 16.0
LONGEST_ROUND_TRIP_NS = 600 * 10**9
HOLD_NS = 1_000_000  # by which two clocks measure the same hold differently, at most


class Way:
    """The passages of one direction in one window [ns], and its jitter, which goes on."""

    def __init__(self, before: "Way | None" = None) -> None:
        self.jitter_ns: float = before.jitter_ns if before else 0.0
        self._last: int | None = before._last if before else None
        self.packets = self.total = self.most = 0
        self.least = Shortest(0, 0)

    def add(self, at_ns: int, passage_ns: int) -> None:
        """Take a passage, seen at an instant of this end's clock."""
        if self._last is not None:
            self.jitter_ns += (abs(passage_ns - self._last) - self.jitter_ns) / JITTER_PACKETS
        self._last = passage_ns
        if not self.packets or passage_ns < self.least.passage_ns:
            self.least = Shortest(at_ns, passage_ns)
        self.most = max(self.most, passage_ns) if self.packets else passage_ns
        self.packets += 1
        self.total += passage_ns


class Passages(NamedTuple):
    """The passages of both directions in one window, which began at ``start_ns``."""

    start_ns: int
    out: Way
    into: Way


class OneWay(NamedTuple):
    """Delay of one direction [s]: the least of the last minute, and of the last whole second."""

    least_s: float
    mean_s: float
    most_s: float
    jitter_s: float


class PathEstimate(NamedTuple):
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
        self.windows: list[Passages] = []  # whole ones; a new list each time, for other threads
        self.out, self.into = Way(), Way()
        self._start_ns = 0
        self._echoed = 0

    def add(self, packet: WavePacket, came_ns: int) -> None:
        """Take a packet that came in at this instant of this end's clock."""
        if came_ns - self._start_ns >= WINDOW_NS:
            if self.out.packets and self.into.packets:
                window = Passages(self._start_ns, self.out, self.into)
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
        """Return what is known; None before a whole window, or if the round trip is below 0."""
        windows = self.windows
        found = latest_line([(window.out.least, window.into.least) for window in windows])
        if found is None:
            return None
        line, before = found  # the path changed since those before
        last = windows[-1]
        theta_ns = line.theta_ns(last.start_ns + WINDOW_NS // 2)

        def one_way(name: str, sign: int) -> OneWay:  # passages out hold theta, in less it
            way: Way = getattr(last, name)
            seen = [getattr(window, name).least for window in windows[before:]]
            least_ns = min(each.passage_ns - sign * line.theta_ns(each.at_ns) for each in seen)
            mean_ns, most_ns = (ns - sign * theta_ns for ns in (way.total / way.packets, way.most))
            all_ns = least_ns, mean_ns, most_ns, getattr(self, name).jitter_ns
            return OneWay(*(ns * 1e-9 for ns in all_ns))

        out, into, open_s = one_way("out", 1), one_way("into", -1), line.open_ns * 1e-9
        round_trip_s = out.least_s + into.least_s
        if round_trip_s < -2.0 * open_s:
            return None
        of_clocks = theta_ns * 1e-9, line.rate * 1e6, line.rate_open * 1e6
        return PathEstimate(out, into, open_s, line.one_clock, *of_clocks, round_trip_s)
