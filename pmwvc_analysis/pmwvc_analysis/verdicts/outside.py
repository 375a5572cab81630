# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Which positions left their bounds in a session, and whether its loop was passive."""

import numpy as np

from pmwvc_analysis.budget.criterion import tolerance
from pmwvc_analysis.budget.energy import server_sums, user_energies
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.felt import touching
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces


def passive(traces: SessionTraces, scenario: Scenario | None) -> bool:
    """Tell whether all ports of users are passive, and the server gave and holds no more than it
    took in: the energy of such a loop is bounded.
    """
    energies, server = user_energies(traces, scenario), traces.server
    if server is None or not energies or any(each.passive is not True for each in energies):
        return False
    taken, given, holds = server_sums(server)
    return bool((taken - given - holds >= -tolerance(taken) - tolerance(holds)).all())


def outside_of(traces: SessionTraces, scenario: Scenario | None) -> tuple[str, float]:
    """Return what is not finite or far outside the workspace, in words, and since when [s]; empty
    when nothing is.
    """
    known = scenario.users if scenario else ()
    workspace = max((u.device.workspace_m for u in known), default=th.DEFAULT_WORKSPACE_M)
    positions = [(f"{user.name}'s device", user.x_m, user.time_s) for user in traces.users]
    if (server := traces.server) is not None:
        touched = np.any([touching(server, i) for i in range(len(server.users))], axis=0)
        latest_s = np.maximum.accumulate(np.where(touched, server.time_s, -np.inf))
        held = ~(server.time_s - latest_s >= th.SETTLE_S)  # else it coasts
        held |= ~np.isfinite(server.x_o).all(axis=-1)
        positions.append(("the object", server.x_o[held], server.time_s[held]))
        for name, x_s, state in zip(server.users, server.x_s, server.state, strict=True):
            present = state > 0
            positions.append((f"{name}'s avatar", x_s[present], server.time_s[present]))
    for name, x, time_s in positions:
        if not np.isfinite(x).all():
            return f"{name}: a position is not a number", 0.0
        far = np.flatnonzero(np.abs(x).max(axis=-1, initial=0.0) > th.WORKSPACES * workspace)
        if len(far):
            space = f"the workspace (+-{workspace * 1e3:.0f} mm)"
            return f"{name} left {space} at {time_s[far[0]]:.2f} s", float(time_s[far[0]])
    return "", 0.0
