# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The distance of a device from its avatar: what is kept of it since joining, and the rest.

Where a user joins, the avatar may have to begin elsewhere than its device is. That distance is
kept, less what the avatar has slid to its device since; position error is what goes beyond it::

    kept  = position sent - x_s     at the first coupled step: device's frame less server's
    kept <- kept - slid
    error = x_m - x_s - kept

A stay ends where the user leaves, or its master or the server is started again.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.traces.holes import starts
from pmwvc_analysis.traces.sums import begins
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.ends.server_end import kept_words
from pmwvc_core.frame import Presence
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

ROUNDED_S = 1e-6  # of a recorded time


class Apart(NamedTuple):
    """Position error and distance kept at steps of the server, ``(step, dof)`` [m]."""

    time_s: Array
    error: Array
    kept: Array


def apart(traces: SessionTraces, user: UserTraces) -> Apart | None:
    """Return how far a device is from its avatar in each of its stays; None where it had none."""
    server = traces.server
    if server is None or user.name not in server.users or not len(server.time_s):
        return None
    index = server.users.index(user.name)
    times, state = server.time_s, server.state[index]
    there = (state > 0) & (times >= user.time_s[0]) & (times <= user.time_s[-1])
    joins = []
    if (came := traces.packets.get(f"/server/{user.name}/wave_up")) is not None:
        _, at = np.unique(came.epoch, return_index=True)  # of each start of its master
        joins = np.searchsorted(times, came.time_s[at] - 0.5 * user.tick_s).tolist()
    first_rows = sorted({*np.flatnonzero(begins(there)).tolist(), *joins, *starts(server)})
    packets = traces.packets.get(f"/server/{user.name}/wave_down")
    distance = user.x_m[user.rows_at(times)] - server.x_s[index]
    kept = np.zeros_like(distance)
    rows = np.zeros(len(times), dtype=bool)
    for stay in np.split(np.arange(len(times)), first_rows):
        coupled = np.flatnonzero(there[stay] & (state[stay] == Presence.COUPLED))
        if len(coupled):
            since, joined = stay[coupled[0] :], stay[coupled[0]]
            first = distance[joined]
            if packets is not None:
                sent = int(np.searchsorted(packets.time_s, times[joined] - ROUNDED_S))
                before_s = times[joined] + server.periods_s[joined]
                if sent < len(packets.position) and packets.time_s[sent] < before_s:
                    position = packets.position[sent]
                    if np.isfinite(position).all():
                        first = position - server.x_s[index][joined]
            kept[since] = first - _slid(server, index, since, first)
            rows[since] = there[since]
    return Apart(times[rows], (distance - kept)[rows], kept[rows]) if rows.any() else None


def kept_text(kept_m: Any, scenario: Scenario) -> str:
    """Return in words what is kept of the distance at joining [m], and why, if it is worth it."""
    if kept_m is None or not np.isfinite(np.array(kept_m, dtype=float)).all():
        return ""
    of = {"waves": has_waves(scenario.controller), "black_box": scenario.coupling.black_box}
    return kept_words(float(np.linalg.norm(kept_m)), **of)


def _slid(server: ServerTraces, index: int, rows: NDArray[np.intp], most: Array) -> Array | float:
    """Return how far an avatar behind waves has slid in a stay, at most ``most``, a vector [m]:
    the way without contact that is not that of its velocity.
    """
    if not np.isfinite(server.u_s[index][rows]).all():
        return 0.0
    x, xd = server.x_s[index][rows], server.xd_s[index][rows]
    steps = np.diff(x, axis=0, prepend=x[:1]) - xd * server.periods_s[rows, np.newaxis]
    follows = np.diff(server.step[rows], prepend=server.step[rows[0]]) == 1
    free = follows & ~server.contact[index][rows]
    way = np.cumsum(np.where(free[:, np.newaxis], steps, 0.0), axis=0)
    return np.asarray(np.clip(way, np.minimum(most, 0.0), np.maximum(most, 0.0)))
