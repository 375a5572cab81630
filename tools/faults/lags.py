# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The time that waves take from port to port, T1 + T2, by two routes that know nothing of each
other: the playouts' own report, and a fit of the waves' displacement at both ends.
"""

from typing import Any

import numpy as np

from pmwvc_core.frame import ServerRow
from pmwvc_core.law.channel.arrivals import StrictArrivals
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.session import SteppedSession
from pmwvc_core.traces import SessionTraces

LONGEST_S = 0.6  # that the fit looks for, one way
FITTED_S = 3.0  # of the session's end


class WatchedBatch(SteppedSession):
    """A session whose playouts are asked, at every step of the server, how late they are."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.lags_s: list[list[float]] = []  # user by user

    def _note_step(self, tick: int, now_ns: int, row: ServerRow) -> None:
        super()._note_step(tick, now_ns, row)
        self.lags_s.append(
            [
                sum(
                    (now_ns - each.counting.sent_ns) * 1e-9 + each.playout.pace.store_s
                    for each in (guest.arrivals, user.loop.s.arrivals)
                    if isinstance(each, StrictArrivals) and each.counting.begun
                )
                for user, guest in zip(self.users, self.server.s.guests, strict=True)
            ]
        )

    def reported_s(self, user: int, rows: Any) -> float:
        """Return the median of T1 + T2 over steps, as the playouts have it [s]."""
        return float(np.median(np.array(self.lags_s)[rows, user]))


def fitted_s(traces: SessionTraces, user: int) -> float:
    """Return T1 + T2 by which the displacements of both waves fit those of the other end [s].

    A displacement undelivered for all of that time is a constant between them: it does not count.
    """
    server, own = traces.server, traces.users[user]
    assert server is not None
    steps = server.time_s + server.periods_s
    up = np.cumsum(np.ravel(own.u_m_lp)) * own.tick_s
    down = np.cumsum(np.ravel(own.v_m)) * own.tick_s
    at_server = [np.cumsum(np.ravel(w[user]) * server.periods_s) for w in (server.u_s, server.v_s)]
    ticks = own.time_s + own.tick_s
    return _delay_s(ticks, up, steps, at_server[0]) + _delay_s(steps, at_server[1], ticks, down)


def _delay_s(times: Array, sent: Array, later: Array, played: Array) -> float:
    """Return the delay that fits best: played(t) = sent(t - delay) and a constant."""
    rows = later > later[-1] - FITTED_S
    at, wanted = later[rows], played[rows]
    delays = np.arange(0.0, LONGEST_S, 0.5e-3)
    off = [np.std(wanted - np.interp(at - delay, times, sent)) for delay in delays]
    return float(delays[int(np.argmin(off))])
