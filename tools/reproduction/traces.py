# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From a simulated session to the curves of the dissertation's experiments."""

from typing import Any

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.traces import SessionTraces

LAST_S = 0.5  # the end of a session, over which steady values are means


def curves(traces: SessionTraces, *, every_s: float) -> dict[str, Any]:
    """Return positions [mm] and forces [N] of all users, thinned out."""
    time_s = np.arange(0.0, float(traces.users[0].time_s[-1]), every_s)

    def at(times: Array, values: Array) -> Array:
        place = np.clip(np.searchsorted(times, time_s, side="right") - 1, 0, len(times) - 1)
        return np.asarray(values[place], dtype=float)

    server = traces.server
    assert server is not None, "a simulated session has a server"
    found: dict[str, Any] = {"time_s": time_s, "x_o_mm": 1e3 * at(server.time_s, server.x_o[:, 0])}
    found["target_mm"] = 1e3 * at(server.time_s, server.target[:, 0])
    for number, user in enumerate(traces.users, start=1):
        present = server.state[number - 1] > 0
        x_s = np.where(present, server.x_s[number - 1][:, 0], np.nan)
        f_s = np.where(present, server.f_s[number - 1][:, 0], np.nan)
        found[f"x_{number}_mm"] = 1e3 * at(user.time_s, user.x_m[:, 0])
        found[f"x_s{number}_mm"] = 1e3 * at(server.time_s, x_s)
        found[f"f_{number}_n"] = at(user.time_s, user.f_applied[:, 0])
        found[f"f_s{number}_n"] = at(server.time_s, f_s)
    return found


def last_mean(time_s: Array, values: Array) -> float:
    """Return the mean over the end of a session."""
    return float(np.mean(values[time_s > time_s[-1] - LAST_S]))


def limited_ticks(traces: SessionTraces) -> int:
    """Return at how many ticks, from the first force of the hand on, the safety limits changed the
    force of the first user.
    """
    user = traces.users[0]
    acts = np.flatnonzero(np.any(user.f_h != 0.0, axis=-1))
    begin = int(acts[0]) if len(acts) else 0
    changed = np.abs(user.f_m - user.f_applied).max(axis=-1) > 1e-9
    return int(changed[begin:].sum())
