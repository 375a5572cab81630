# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reasons for which a replay cannot be its recording to the last bit, each with its time."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.replay.loop_times import tick_numbers
from pmwvc_analysis.replay.network import own_sender
from pmwvc_analysis.traces.holes import SERVER, holes, of_user
from pmwvc_analysis.traces.server_starts import starts
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces

NEAR_S = 0.001  # a change is noted just before the tick or step that took it over


class Limit(NamedTuple):
    """Why a replay is not exact from a time on [s]."""

    time_s: float
    why: str


def limits(traces: SessionTraces, recorded: Scenario, hands: Mapping[str, str]) -> list[Limit]:
    """Return, by time, why an unchanged replay with these kinds of hands cannot be exact."""
    found = [*_unrecorded(traces), *_restarts(traces), *_unnamed_changes(traces)]
    for user in recorded.users:
        if traces.live and not user.device.is_simulated:
            why = f"{user.name}: the device was a real one; here its model moves"
            found.append(Limit(0.0, why))
        targets = traces.targets.get(user.name)
        led = user.operator.from_outside and targets is not None and len(targets.time_s) > 0
        if led and hands[user.name] == "operator":  # the recorder may get a target later
            why = f"{user.name}: the tick at which a target reached the hand was not recorded"
            found.append(Limit(0.0, why))
    found += [limit for u in traces.users if hands[u.name] == "force" for limit in _pauses(u)]
    return sorted(found)


def _pauses(user: UserTraces) -> Iterator[Limit]:
    """Yield pauses of a loop in which a recorded hand pushed a device that moved on."""
    gaps = [(hole.start_s, hole.end_s) for hole in of_user(user)]
    missed = tick_numbers(np.diff(user.time_s), user.tick_s) - 1
    pushed = (np.nan_to_num(user.f_h) != 0.0).any(axis=-1)
    for row in np.flatnonzero((missed > 0) & (pushed[:-1] | pushed[1:])).tolist():
        start_s, end_s = user.time_s[row : row + 2].tolist()
        if not any(first < end_s and start_s < last for first, last in gaps):
            why = f"{user.name}: the force of the hand in {missed[row]} ticks that did not run"
            yield Limit(start_s + user.tick_s, f"{why} is interpolated")


def _unrecorded(traces: SessionTraces) -> Iterator[Limit]:
    """Yield what the recording lacks."""
    for hole in holes(traces):
        what = "steps of the server" if hole.owner == SERVER else "blocks of its trace"
        who = "" if hole.owner == SERVER else f"{hole.owner}: "
        yield Limit(hole.start_s, f"{who}{hole.missing} {what} were not recorded")
    for user in traces.users:
        for way in ("up", "down"):
            name = f"{user.name}/{way}"
            taken = traces.taken.get(name)
            if taken is None:
                why = f"{name}: when packets were taken in was not recorded"
                yield Limit(0.0, why)
                continue
            strange = taken.epoch != own_sender(traces, name)
            if strange.any():
                rows = traces.server if way == "up" else user
                time_s = float(rows.time_s[taken.row[strange][0]]) if rows is not None else 0.0
                why = f"{name}: {strange.sum()} packets of another start of the sender came"
                yield Limit(time_s, why)


def _restarts(traces: SessionTraces) -> Iterator[Limit]:
    """Yield nodes that were started again."""
    why = "was started again: a replay starts every node once"
    for user in traces.users:
        for row in np.flatnonzero(user.epoch[1:] != user.epoch[:-1]).tolist():
            yield Limit(float(user.block_time_s[row]), f"{user.name}: the master {why}")
    for start in starts(traces.server) if traces.server is not None else ():
        yield Limit(start.begins_s, f"the server {why}")


def _unnamed_changes(traces: SessionTraces) -> Iterator[Limit]:
    """Yield what a loop took over in flight and no change of a parameter names."""
    if not traces.live:
        return
    named = np.array([time_s for time_s, _ in traces.settings])
    loops = [(f"{u.name}: the master", u.changes, u.time_s[u.block_rows]) for u in traces.users]
    if traces.server is not None:
        loops.append(("the server", traces.server.changes, traces.server.time_s))
    for who, changes, time_s in loops:
        for row in np.flatnonzero(np.diff(changes) > 0).tolist():
            at_s = float(time_s[row + 1])
            if not np.any(np.abs(named - at_s) < NEAR_S):
                why = f"{who} took over a change that no recorded parameter event names"
                yield Limit(at_s, why)
