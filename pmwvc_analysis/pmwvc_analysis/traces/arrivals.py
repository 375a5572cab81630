# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""How evenly packets came in: the ratio of time spent waiting for late ones.

A packet states the time that it stands for. One that comes more than half of that time later than
it is due, counted from the newest one before, is late; lost ones make the next one late.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.traces import PacketTraces

LATE = 0.5  # of the time that a packet stands for
UNEVEN = 0.01  # of the time spent waiting for late packets: more than that moves a device


def waited(links: Iterable[PacketTraces], start_s: float, end_s: float) -> float:
    """Return the largest ratio, over the links, of time spent in intervals before late packets."""
    span_s = end_s - start_s
    if span_s <= 0.0:
        return 0.0
    return max((_waited_s(packets, start_s) / span_s for packets in links), default=0.0)


def _waited_s(packets: PacketTraces, start_s: float) -> float:
    newest = _newest(packets)
    times_s = packets.time_s[newest]
    gaps_s, due_s = np.diff(times_s), packets.period_s[newest][1:]
    late = (gaps_s > (1.0 + LATE) * due_s) & (times_s[1:] > start_s)
    begun_s = np.maximum(times_s[:-1], start_s)
    return float((times_s[1:] - begun_s)[late].sum())


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
