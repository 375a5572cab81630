# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The offset and the drift between the clocks of two ends, from the least passages of packets.

A passage is the arrival by the receiver's clock less the departure by the sender's. With theta =
the other end's clock less this one's and delays d_out, d_in >= 0::

    out = d_out + theta        in = d_in - theta

So -min(in) <= theta <= min(out) for a theta that stands still. The sum of both least delays is
known; how it is divided is not: theta and an asymmetry of the path look the same. The middle is
taken, half the width is the bound.

Clocks drift. Over windows the least passages stay, theta = (out - in)/2 up to the asymmetry, which
is constant while the least delays are. A window whose least round trip is longer than the
shortest by 2 e has its middle off by e, and by what is usual for all windows, the best one
included: the median of e, and twice the median scatter of the middles about a line. The drift is
every slope that fits all windows so, within ``MOST_DRIFT``; that interval is given, all of it for
a few windows. Where no slope fits, the least delays themselves changed.

Equation: docs/theory.md 13.11.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array

ONE_CLOCK_NS = 1_000_000_000  # a larger sum of both delays does not decide whether it is one clock
MOST_DRIFT = 500e-6  # of two computers' clocks
FEWEST = 8  # windows that show a drift
READING_NS = 1_000.0  # a clock is read to this
WITHIN_NS = 500_000_000.0  # half a window


class Least(NamedTuple):
    """The least passage of a window, and when it was seen on this end's clock [ns]."""

    at_ns: int
    passage_ns: int


@dataclass(frozen=True)
class ClockLine:
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


def clock_line(out: Sequence[Least], into: Sequence[Least]) -> ClockLine | None:
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
    return ClockLine(
        offset_ns=reference + (high + low) / 2.0,
        rate=rate,
        at_ns=begin_ns + round(centre),
        open_ns=max(high - low, 0.0) / 2.0 + drifted + READING_NS,
        rate_open=rate_open,
        one_clock=False,
    )


def latest_line(windows: Sequence[tuple[Least, Least]]) -> tuple[ClockLine, int] | None:
    """Return the line through as many of the last windows (least passages out and in of each,
    ascending in time) as one fits, and how many came before; None without windows.
    """
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
