# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Intervals of time [s]: holes of a recording, and those in which a user's energies are known.

A publisher numbers what it sends: a master its blocks, the server its steps. Where a number is
missing, the recording has a hole, and nothing is judged there. Where the numbers go on and only
time has passed, the loop did not run (:mod:`.events` calls that a stall).

A hole in the record of running sums hides only what happened inside it: a user is judged again
from the end of its first block after it. Where a master or the server is started again its
balances end: what was under way then is not known. A loop that stands still interrupts none: its
last force stays on, and gives out - F (x_after - x_before).

Equations: docs/theory.md 13, Gaps.
"""

import math
from collections.abc import Iterable
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.traces.thresholds import STALL_PERIODS, STALL_S
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

SERVER = "server"


class Kind(StrEnum):
    """Why something is not judged, and what its owner did."""

    GAP = "was not recorded"
    RESTART = "was started again"
    CHANGE = "took over a new parameter"


class Unjudged(NamedTuple):
    """A time in which what a publisher did is unknown, and why."""

    start_s: float
    end_s: float
    owner: str  # a user, or ``server``
    kind: Kind = Kind.GAP
    missing: int = 0  # of a hole: blocks of a master, steps of the server

    @property
    def why(self) -> str:
        """The reason in words."""
        return f"{self.owner} {self.kind}"


def starts(server: ServerTraces) -> list[int]:
    """Return the first row of every start of the server after its first one."""
    return (np.flatnonzero(np.diff(server.step) < 0) + 1).tolist()


def ran_s(server: ServerTraces, traces: SessionTraces) -> Array:
    """Return when each step ran [s]: its deadline, and its lateness where that is known."""
    late_s = traces.metadata.get("server_lateness_s")
    if late_s is None or len(late_s) != len(server.time_s):
        return server.time_s
    return np.asarray(server.time_s + late_s)


def holes(traces: SessionTraces) -> list[Unjudged]:
    """Return every hole of a recording, in the order of time."""
    found = [hole for user in traces.users for hole in of_user(user)]
    if (server := traces.server) is not None:
        found += of_server(server)
    return sorted(found, key=lambda hole: (hole.start_s, hole.owner))


def of_user(user: UserTraces) -> list[Unjudged]:
    """Return the holes in the trace of one master; simulated blocks have no numbers and none."""
    begins_s = user.time_s[np.minimum(user.block_rows, len(user.time_s) - 1)]
    again = (np.flatnonzero(np.diff(user.epoch)) + 1).tolist()
    return _missing(user.name, user.block_number, begins_s, user.block_time_s, again)


def of_server(server: ServerTraces) -> list[Unjudged]:
    """Return the holes in the trace of the server."""
    ends_s = server.time_s + server.periods_s
    return _missing(SERVER, server.step, server.time_s, ends_s, starts(server))


def _missing(
    owner: str, numbers: NDArray[np.int64], begins_s: Array, ends_s: Array, again: list[int]
) -> list[Unjudged]:
    """Return where numbers are missing: they count from one, once more in the rows ``again``."""
    before, found = np.append(0, numbers[:-1]), []
    before[again] = 0
    lacking = numbers - before[: len(numbers)] - 1
    for row in np.flatnonzero(lacking > 0).tolist():
        start_s, end_s = float(ends_s[row - 1]) if row else 0.0, float(begins_s[row])
        if row in again:  # it ran from then on at the earliest
            lasted_s = float(lacking[row] * (ends_s[row] - begins_s[row]))
            start_s = max(start_s, end_s - lasted_s)
        found.append(Unjudged(start_s, end_s, owner, missing=int(lacking[row])))
    return found


def pauses(
    time_s: Array, period_s: float, known: Iterable[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Return from when to when a loop did not run [s], but where intervals known explain that."""
    paused = np.diff(time_s) > max(STALL_S, STALL_PERIODS * period_s)
    for start_s, end_s in known:
        paused &= (start_s >= time_s[1:]) | (time_s[:-1] >= end_s)
    return [(float(time_s[row]), float(time_s[row + 1])) for row in np.flatnonzero(paused)]


class Stretch(NamedTuple):
    """The time in which a user's energies are known [s], but for what is ``unjudged``."""

    start_s: float
    end_s: float
    unjudged: list[Unjudged]

    def known(self, times: Array) -> Flags:
        """Tell which instants are judged."""
        inside = np.asarray((times >= self.start_s) & (times < self.end_s))
        for hole in self.unjudged:
            inside &= (times <= hole.start_s) | (times >= hole.end_s)
        return inside


def stretch(user: UserTraces, server: ServerTraces) -> Stretch:
    """Return what of a session is judged for one user, where its master and the server were
    recorded: up to where either was started again.
    """
    ran, ends_s = user.time_s + user.lateness_s, user.block_time_s[block_of_ticks(user)]
    # where the recorder found it only when it was running
    start_s = float(ends_s[0]) if user.tick[0] > 0 else -math.inf
    end_s, last_s = float(ran[-1] + 1.5 * user.tick_s), float(max(ran[-1], server.time_s[-1]))
    unjudged = []
    for row in gaps(user):
        last_ran_s, back_s = float(ran[row] + 0.5 * user.tick_s), float(ends_s[row + 1])
        unjudged.append(Unjudged(last_ran_s, back_s, user.name))
    unjudged += of_server(server)
    again = [(float(server.time_s[row]), SERVER) for row in starts(server)[:1]]
    for row in np.flatnonzero(np.diff(user.tick) < 0)[:1]:
        # where its last tick led to is not known: up to the block before
        blocks_s = user.block_time_s[user.block_time_s < user.time_s[row] + 0.5 * user.tick_s]
        again.append((float(blocks_s.max(initial=max(start_s, 0.0))), user.name))
    if again:
        end_s, who = min(again)
        unjudged = [each for each in unjudged if each.end_s < end_s]
        unjudged.append(Unjudged(end_s, last_s, who, Kind.RESTART))
    return Stretch(start_s, end_s, unjudged)


def gaps(user: UserTraces) -> NDArray[np.intp]:
    """Return the rows of ticks behind which blocks are missing in the record. Ticks that the loop
    left out are no gap: its last force was held on, and its sums hold.
    """
    rows = np.flatnonzero(np.diff(user.tick) > 1)
    if len(user.block_number) != len(user.block_time_s):
        return rows
    number = user.block_number[block_of_ticks(user)]
    return rows[number[rows + 1] - number[rows] > 1]


def skips(user: UserTraces) -> NDArray[np.intp]:
    """Return the rows of ticks behind which the loop itself left ticks out."""
    return np.setdiff1d(np.flatnonzero(np.diff(user.tick) > 1), gaps(user))


def block_of_ticks(user: UserTraces) -> NDArray[np.intp]:
    """Return the row of the block that each tick belongs to; the last one for those behind it."""
    block = np.searchsorted(user.block_time_s, user.time_s + 0.5 * user.tick_s)
    return np.minimum(block, len(user.block_time_s) - 1)
