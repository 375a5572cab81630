# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""How evenly packets came in: the ratio of time spent waiting for late ones.

A packet states the time that it stands for. One that comes more than half of that time later than
it is due, counted from the newest one before, is late; lost ones make the next one late. One that
has not come by the end is late as well, unless the link was silent for so long that nobody waits.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array
from pmwvc_core.traces import PacketTraces

LATE = 0.5  # of the time that a packet stands for
UNEVEN = 0.01  # of the time spent waiting for late packets: more than that moves a device

GONE_S = 1.0  # of silence at the end, after which nobody waits for a link


def waited(links: Iterable[PacketTraces], start_s: float, end_s: float) -> float:
    """Return the largest ratio, over the links, of time spent in intervals before late packets."""
    span_s = end_s - start_s
    if span_s <= 0.0:
        return 0.0
    lengths_s = (np.diff(_waits(each, start_s, end_s)).sum() for each in links)
    return float(max(lengths_s, default=0.0)) / span_s


def timely(
    links: Iterable[PacketTraces], start_s: float, end_s: float
) -> list[tuple[float, float]]:
    """Return the stretches, from and until [s], in which nothing waited for a late packet."""
    waits = [wait for packets in links for wait in _waits(packets, start_s, end_s).tolist()]
    return without(waits, start_s, end_s)


def without(
    waits: Iterable[tuple[float, float]], start_s: float, end_s: float
) -> list[tuple[float, float]]:
    """Return what is left of a time without some intervals, from and until [s]."""
    found, at_s = [], start_s
    for from_s, until_s in [*sorted(waits), (end_s, end_s)]:
        if from_s > at_s:
            found.append((at_s, min(from_s, end_s)))
        at_s = max(at_s, until_s)
    return found


def _waits(packets: PacketTraces, start_s: float, end_s: float) -> Array:
    """Return the intervals before late packets, from and until [s], ``(waits, 2)``."""
    newest = _newest(packets)
    times_s, due_s = packets.time_s[newest], packets.period_s[newest]
    if len(newest) and 0.0 < end_s - times_s[-1] < GONE_S:
        times_s, due_s = np.append(times_s, end_s), np.append(due_s, due_s[-1])
    gaps_s, due_s = np.diff(times_s), due_s[1:]
    late = (gaps_s > (1.0 + LATE) * due_s) & (times_s[1:] > start_s)
    begun_s = np.maximum(times_s[:-1], start_s)
    return np.stack([begun_s[late], times_s[1:][late]], axis=1)


def _newest(packets: PacketTraces) -> NDArray[np.intp]:
    """Return the rows of packets that were the newest when they came, in that order."""
    order = np.argsort(packets.time_s, kind="stable")
    seq, epoch = packets.seq[order], packets.epoch[order]
    found = np.ones(len(order), dtype=bool)
    for each in np.unique(epoch):
        own = epoch == each
        before = np.maximum.accumulate(np.concatenate([[-1], seq[own]]))[:-1]
        found[own] = seq[own] > before
    return np.asarray(order[found])
