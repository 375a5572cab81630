# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The times of recorded loops: when every tick of a master and every step of the server took its
packets in, on the time line of the replay.

Ticks and steps that a recording lacks (:mod:`pmwvc_analysis.traces.holes`) are taken to have run
on time.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.traces.holes import of_server, of_user
from pmwvc_analysis.traces.stages import Stage
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Steps
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces


class LoopTimes(NamedTuple):
    """The times of one loop: the tick of the session of each row of its traces, when each row
    took its packets in [ns], and the intervals that were not recorded [ns].
    """

    at: Integers
    looked_ns: Integers
    holes_ns: Sequence[tuple[int, int]]


def tick_numbers(time_s: Array, tick_s: float) -> Integers:
    """Return times as ticks of the session."""
    return np.rint(time_s / tick_s).astype(np.int64)


def times_of(rows: UserTraces | ServerTraces, tick_s: float) -> LoopTimes:
    """Return the times of a master's loop, or the server's."""
    at = tick_numbers(rows.time_s, tick_s)
    gaps = of_user(rows) if isinstance(rows, UserTraces) else of_server(rows)
    gaps_ns = [(round(gap.start_s * 1e9), round(gap.end_s * 1e9)) for gap in gaps]
    return LoopTimes(at, at * round(tick_s * 1e9) + rows.nearest_look_ns, gaps_ns)


def unknown_looks(traces: SessionTraces) -> list[str]:
    """Return a note where a recording does not say when its loops took packets in."""
    ends: list[tuple[str, UserTraces | ServerTraces]] = [(u.name, u) for u in traces.users]
    ends += [("the server", traces.server)] if traces.server is not None else []
    unknown = ", ".join(name for name, rows in ends if not len(rows.looked_ns))
    what = "taken for the wake-up of a master, the deadline of a server step"
    return [f"when {unknown} took packets in was not recorded: {what}"] if unknown else []


def ran_ns(loop: LoopTimes, tick_s: float, ticks: int) -> Integers:
    """Return when each tick of the session ran [ns], negative where it did not ``(ticks,)``."""
    tick_ns = round(tick_s * 1e9)
    result = np.full(ticks, -1, dtype=np.int64)
    for start_ns, end_ns in loop.holes_ns:
        lost = np.arange(max(start_ns // tick_ns, 0), min(-(-end_ns // tick_ns), ticks))
        result[lost] = lost * tick_ns
    within = loop.at < ticks
    result[loop.at[within]] = loop.looked_ns[within]
    return result


def counts_from(
    user: UserTraces, traces: SessionTraces, stages: Sequence[Stage], number: int
) -> int:
    """Return the tick of the session at which the loop of a user (number from 0) counts 0: its
    frames begin at the multiples of the rate drops of all stages.
    """
    rate_drops = [stage.scenario.users[number].master.rate_drop for stage in stages]
    grid = user.grid if traces.live else 0
    begins = int(tick_numbers(user.time_s[:1], user.tick_s)[0])
    return begins - (int(user.tick[0]) + grid) % math.lcm(*rate_drops)


def steps(
    traces: SessionTraces, recorded: Scenario, replayed: Scenario, ticks: int
) -> Steps | None:
    """Return when the server stepped; on its own grid where its period was changed."""
    server, tick_s = traces.server, recorded.tick_s
    tick_ns = round(tick_s * 1e9)
    if server is None:
        return None
    loop, period_s = times_of(server, tick_s), replayed.server.period_s
    if period_s != recorded.server.period_s:
        tick = np.arange(loop.at[0], ticks, round(period_s / tick_s))
        return Steps(tick, tick * tick_ns, np.full(len(tick), period_s))
    columns = loop.at.tolist(), loop.looked_ns.tolist(), server.periods_s.tolist()
    rows = [row for row in zip(*columns, strict=True) if row[0] < ticks]
    missing = np.diff(server.step) - 1
    for row in np.flatnonzero(missing > 0).tolist():
        count, lasts = int(missing[row]), float(server.periods_s[row])
        between = np.linspace(loop.at[row], loop.at[row + 1], count + 2)[1:-1]
        rows += [(int(at), int(at) * tick_ns, lasts) for at in between if at < ticks]
    at, looked_ns, lasts_s = zip(*sorted(rows), strict=True)
    return Steps(np.array(at), np.array(looked_ns), np.array(lasts_s))
