# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The distance of a device from its avatar: what is kept of it since joining, and the rest.

Where a user joins, the avatar may have to begin elsewhere than its device is. That distance is
kept, less what the avatar slides to its device later. Packets to a device name where its avatar is
in the device's frame; position error is what goes beyond the distance kept::

    kept  = position sent - x_s, of the newest packet
    error = x_m - x_s - kept
"""

from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.traces.holes import ran_s
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.ends.server_end import kept_words
from pmwvc_core.frame import Presence
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces

ROUNDED_S = 1e-6  # of a recorded time


class Apart(NamedTuple):
    """Position error and distance kept at steps of the server, ``(step, dof)`` [m]."""

    time_s: Array
    error: Array
    kept: Array


def apart(traces: SessionTraces, user: UserTraces) -> Apart | None:
    """Return how far a device is from its avatar since it was first coupled, in each of its stays;
    None where it had none, or no packets of them are on record.
    """
    server, packets = traces.server, traces.packets.get(f"/server/{user.name}/wave_down")
    if server is None or packets is None or user.name not in server.users:
        return None
    index, times = server.users.index(user.name), server.time_s
    x_s = server.x_s[index]
    sent_s = packets.time_s + ROUNDED_S
    step = np.searchsorted(ran_s(server, traces), sent_s, side="right") - 1  # of each packet
    step, position = step[step >= 0], packets.position[step >= 0]
    known = np.isfinite(position).all(axis=-1)
    newest = np.full(len(times), -1)
    newest[step[known]] = np.flatnonzero(known)
    newest = np.maximum.accumulate(newest)
    coupled = server.state[index] >= Presence.COUPLED
    inside = (times >= user.time_s[0]) & (times <= user.time_s[-1])
    rows = coupled & inside & (newest >= 0)
    if not rows.any():
        return None
    sent = newest[rows]
    kept = position[sent] - x_s[step[sent]]
    error = user.x_m[user.rows_at(times[rows])] - x_s[rows] - kept
    return Apart(times[rows], error, kept)


def kept_text(kept_m: Any, scenario: Scenario) -> str:
    """Return in words what is kept of the distance at joining [m], and why, if it is worth it."""
    if kept_m is None or not np.isfinite(np.array(kept_m, dtype=float)).all():
        return ""
    of = {"waves": has_waves(scenario.controller), "black_box": scenario.coupling.black_box}
    return kept_words(float(np.linalg.norm(kept_m)), **of)
