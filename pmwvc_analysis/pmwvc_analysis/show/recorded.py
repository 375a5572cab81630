# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Which users a session has, from when to when, and where its recording has holes."""

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.show.chart import Band, Span
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.traces import SessionTraces

WORTH_A_BAND_S = 0.05


def names(traces: SessionTraces) -> list[str]:
    """Return the users in the order of their colours: the server's, then the others."""
    found = list(traces.server.users) if traces.server else []
    return found + [user.name for user in traces.users if user.name not in found]


def end_s(traces: SessionTraces) -> float:
    """Return when the last user ended; without any, when the server did [s]."""
    ends = [float(user.time_s[-1]) for user in traces.users if len(user.time_s)]
    if not ends and traces.server is not None and len(traces.server.time_s):
        ends = [float(traces.server.time_s[-1])]
    return max(ends, default=traces.duration_s)


def until_users_end(traces: SessionTraces) -> NDArray[np.bool_]:
    """Return which steps of the server are not later than the last tick of all users."""
    assert traces.server is not None
    found: NDArray[np.bool_] = traces.server.time_s <= end_s(traces) + 1e-9
    return found


def span(traces: SessionTraces) -> Span:
    """Return the time from the first to the last row of any trace [s]."""
    starts = [float(user.time_s[0]) for user in traces.users if len(user.time_s)]
    if traces.server is not None and len(traces.server.time_s):
        starts.append(float(traces.server.time_s[0]))
    low, high = min(starts, default=0.0), end_s(traces)
    return (low, high) if high > low else (low, low + 1.0)


def holes(time_s: Array, period_s: float) -> list[Span]:
    """Return where neighbouring rows are further apart than ``WORTH_A_BAND_S`` [s]."""
    places = np.flatnonzero(np.diff(time_s) > max(WORTH_A_BAND_S, 1.5 * period_s))
    return [(float(time_s[row]), float(time_s[row + 1])) for row in places]


def bands(traces: SessionTraces) -> list[Band]:
    """Return the stretches that are not in the recording of some user or of the server."""
    found = []
    for user in traces.users:
        found += [
            Band(f"{user.name}: no trace", hole, "soft")
            for hole in holes(user.time_s, user.tick_s)
        ]
    if traces.server is not None:
        server = traces.server
        found += [
            Band("server: no trace", hole, "soft")
            for hole in holes(server.time_s, server.period_s)
        ]
    return found
