# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The events of a session in virtual time, in their order.

Without a recording events lie on their grid; those of one instant come in the order of a frame:
all masters send, the server steps, all ticks (the tick that takes an answer is for
:class:`pmwvc_core.frame.force_loop.ForceLoop` to know). With the times at which the loops of a
recorded session really ran, events come in the order of those times.

Users interact through the network only, so the ticks of one user between two events of other
kinds form a group that is run at once.
"""

import enum
import itertools
import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.frame.schedule import next_on_grid

Integers = NDArray[np.int64]
CHUNK = 8192  # groups unpacked at a time


class EventKind(enum.IntEnum):
    """Kind of an event; events of one instant come in this order."""

    PASS = 0  # a tick that the force loop missed: only the device moves
    SEND = 1
    SERVE = 2
    TICK = 3


@dataclass(frozen=True)
class LoopTimes:
    """The times of one force loop.

    Parameters
    ----------
    first
        Tick of the session with which its first frame starts.
    answer
        Tick of its frame at which it takes the answer.
    changes
        Other rate drops: tick of the session from which each holds, with the next frame start.
    ran_ns
        When each tick of the session ran, negative where it did not ``(ticks,)``; on the grid when
        not given.
    """

    rate_drop: int
    first: int = 0
    answer: int = 0
    changes: Sequence[tuple[int, int]] = ()
    ran_ns: Integers | None = None

    def starts(self, ticks: int) -> Integers:
        """Return the first tick of every frame in a session of so many ticks, and of one behind
        it.
        """
        first = self.first
        grids = [(tick, every, first) for tick, every in self.changes]
        return on_grids(first, ticks, self.rate_drop, first, grids)


@dataclass(frozen=True)
class Steps:
    """The server's steps: tick of the session of each, and when it ran ``(steps,)``."""

    tick: Integers
    ran_ns: Integers

    @classmethod
    def on_grid(
        cls,
        *,
        every: int,
        first: int,
        ticks: int,
        tick_ns: int,
        changes: Sequence[tuple[int, int, int]] = (),
    ) -> "Steps":
        """Return steps every so many ticks; for ``changes`` see :func:`on_grids`."""
        tick = on_grids(first, ticks, every, first, changes)
        tick = tick[tick < ticks]
        return cls(tick, tick * tick_ns)


def on_grids(
    first: int, ticks: int, every: int, phase: int, changes: Sequence[tuple[int, int, int]]
) -> Integers:
    """Return the points of a grid that changes, one at ``ticks`` or later among them.

    Parameters
    ----------
    first, ticks
        First point, and end [ticks].
    every, phase
        Distance and phase of the points at first.
    changes
        Tick from which, at the next point, another grid holds; its distance and phase.
    """
    points, pending = [first], deque(changes)
    while points[-1] < ticks:
        now = points[-1]
        while pending and pending[0][0] <= now:
            _, every, phase = pending.popleft()
        if not pending:
            rest = np.arange(next_on_grid(now, every, phase), ticks + every, every)
            return np.concatenate([points, rest]).astype(np.int64)
        points.append(next_on_grid(now, every, phase))
    return np.array(points, dtype=np.int64)


def first_tick(time_s: float, tick_ns: int) -> int:
    """Return the first tick at a time or later."""
    return math.ceil(time_s * 1e9 / tick_ns)


EventGroup = tuple[int, int, list[int], list[int]]  # kind, user, times [ns], ticks


def events(loops: Sequence[LoopTimes], steps: Steps, *, ticks: int, tick_ns: int) -> Integers:
    """Return all events in their order, ``(events, 4)``: time [ns], kind, whose, tick.

    For the server ``tick`` is the number of its step.

    Parameters
    ----------
    ticks, tick_ns
        Length of the session, and of a tick [ns].
    """
    parts = [_rows(steps.ran_ns, EventKind.SERVE, 0, np.arange(len(steps.tick), dtype=np.int64))]
    for who, loop in enumerate(loops):
        parts += _of_loop(loop, who, ticks=ticks, tick_ns=tick_ns)
    table = np.concatenate(parts)
    return table[np.lexsort((table[:, 3], table[:, 2], table[:, 1], table[:, 0]))]


def groups(table: Integers) -> Iterator[EventGroup]:
    """Yield groups: one event, or the ticks of one user between two events of other kinds."""
    ticking = table[:, 1] == EventKind.TICK
    stretch = np.cumsum(~(ticking & np.roll(ticking, 1)))
    table = table[np.lexsort((table[:, 2], stretch))]
    begins = np.ones(len(table), dtype=np.bool_)
    begins[1:] = (np.diff(stretch) != 0) | (np.diff(table[:, 2]) != 0)
    bounds = np.append(np.flatnonzero(begins), len(table))
    for chosen in range(0, len(bounds) - 1, CHUNK):
        edges = bounds[chosen : chosen + CHUNK + 1]
        time_ns, kind, who, tick = table[edges[0] : edges[-1]].T.tolist()
        for start, end in itertools.pairwise((edges - edges[0]).tolist()):
            yield kind[start], who[start], time_ns[start:end], tick[start:end]


def _of_loop(loop: LoopTimes, who: int, *, ticks: int, tick_ns: int) -> list[Integers]:
    """Return the events of one force loop, ``(events, 4)`` each kind."""
    tick, times = _ran(loop, ticks=ticks, tick_ns=tick_ns)
    if not len(tick):
        return []
    sends, at_ns = frame_events(loop, 0, ticks=ticks, tick_ns=tick_ns)
    found = [
        _rows(times, EventKind.TICK, who, tick),
        _rows(at_ns, EventKind.SEND, who, sends),
    ]
    if len(tick) <= tick[-1] - tick[0]:
        missed = np.setdiff1d(np.arange(tick[0], tick[-1], dtype=np.int64), tick)
        found.append(_rows(times[np.searchsorted(tick, missed)], EventKind.PASS, who, missed))
    return found


def frame_events(
    loop: LoopTimes, tick_in_frame: int, *, ticks: int, tick_ns: int
) -> tuple[Integers, Integers]:
    """Return tick and time [ns] of the first tick of every frame at ``tick_in_frame`` or later, of
    a shorter frame the last one.

    A loop sends at 0 and takes the answer at ``loop.answer``.
    """
    tick, times = _ran(loop, ticks=ticks, tick_ns=tick_ns)
    starts = loop.starts(ticks)
    frame = np.searchsorted(starts, tick, side="right") - 1
    lengths = np.diff(starts, append=starts[-1] + loop.rate_drop)
    may = tick - starts[frame] >= np.minimum(tick_in_frame, lengths[frame] - 1)
    begins = np.diff(frame[may], prepend=-1) > 0  # frames come in their order, from 0
    return tick[may][begins], times[may][begins]


def _ran(loop: LoopTimes, *, ticks: int, tick_ns: int) -> tuple[Integers, Integers]:
    """Return the ticks that a loop ran, and when [ns]."""
    tick = np.arange(loop.first, ticks, dtype=np.int64)
    if loop.ran_ns is None:
        return tick, tick * tick_ns
    times = loop.ran_ns[loop.first : ticks]
    return tick[times >= 0], times[times >= 0]


def _rows(time_ns: Integers, kind: EventKind, who: int, tick: Integers) -> Integers:
    same = np.ones_like(tick)
    return np.stack([time_ns, int(kind) * same, who * same, tick], axis=1)
