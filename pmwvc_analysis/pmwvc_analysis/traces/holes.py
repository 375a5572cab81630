# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Intervals of time [s], and holes in the recording: those of which messages are missing.

A publisher numbers what it sends: a master its blocks, the server its steps. Where a number is
missing, the recording has a hole, and nothing is judged there. Where the numbers go on and only
time has passed, the loop did not run (:mod:`.events` calls that a stall).
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.traces.server_starts import ends, ran_s, starts
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

GAP = "not recorded"
SERVER = "server"


class Unjudged(NamedTuple):
    """A time in which a balance is unknown, and why."""

    start_s: float
    end_s: float
    why: str


class Hole(NamedTuple):
    """An interval of which a publisher's messages are missing [s], and how many."""

    owner: str  # a user, or ``server``
    start_s: float
    end_s: float
    missing: int  # blocks of a master, steps of the server

    @property
    def unjudged(self) -> Unjudged:
        """Return the interval as one that is not judged."""
        return Unjudged(self.start_s, self.end_s, f"{GAP} ({self.owner})")


def holes(traces: SessionTraces) -> list[Hole]:
    """Return every hole of a recording, in the order of time."""
    found = [hole for user in traces.users for hole in of_user(user)]
    if (server := traces.server) is not None:
        found += of_server(server)
        # at the ends of servers that were killed: steps that their packets show
        for start, end in zip(starts(server), ends(server, traces), strict=True):
            period_s = float(server.periods_s[start.last])
            ran = float(ran_s(server, traces)[start.last])
            longer_s = end.died_s - ran
            if longer_s > 0.5 * period_s:
                missing = max(round(longer_s / period_s), 1)
                found.append(Hole(SERVER, ran + 0.5 * period_s, ran + longer_s, missing))
    return sorted(found, key=lambda hole: (hole.start_s, hole.owner))


def of_user(user: UserTraces) -> list[Hole]:
    """Return the holes in the trace of one master; simulated blocks have no numbers and none."""
    if not len(user.time_s):
        return []
    found = []
    first_s = user.time_s[np.minimum(user.block_rows, len(user.time_s) - 1)]
    for row, number in enumerate(user.block_number.tolist()):
        follows = row > 0 and (not len(user.epoch) or user.epoch[row] == user.epoch[row - 1])
        missing = number - (int(user.block_number[row - 1]) if follows else 0) - 1
        if missing > 0:
            start_s = float(user.block_time_s[row - 1]) if row else 0.0
            found.append(Hole(user.name, start_s, float(first_s[row]), missing))
    return found


def of_server(server: ServerTraces) -> list[Hole]:
    """Return the holes in the trace of the server."""
    found = []
    if len(server.step) and server.step[0] > 1:
        found.append(Hole(SERVER, 0.0, float(server.time_s[0]), int(server.step[0]) - 1))
    for start in starts(server):
        if (missing := int(server.step[start.row]) - 1) > 0:
            at_s = float(server.time_s[start.row])
            found.append(Hole(SERVER, start.begins_s, at_s, missing))
    jumps = np.diff(server.step)
    for row in np.flatnonzero(jumps > 1).tolist():
        start_s = float(server.time_s[row] + server.periods_s[row])
        found.append(Hole(SERVER, start_s, float(server.time_s[row + 1]), int(jumps[row]) - 1))
    return found


def without(
    intervals: Iterable[tuple[float, float]], start_s: float, end_s: float
) -> list[tuple[float, float]]:
    """Return what is left of a time without some intervals."""
    found, at_s = [], start_s
    for from_s, until_s in [*sorted(intervals), (end_s, end_s)]:
        if from_s > at_s:
            found.append((at_s, min(from_s, end_s)))
        at_s = max(at_s, until_s)
    return found


def merged(intervals: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return intervals in the order of time, overlapping ones as one."""
    found: list[tuple[float, float]] = []
    for start_s, end_s in sorted(intervals):
        if found and start_s <= found[-1][1]:
            found[-1] = (found[-1][0], max(found[-1][1], end_s))
        else:
            found.append((start_s, end_s))
    return found
