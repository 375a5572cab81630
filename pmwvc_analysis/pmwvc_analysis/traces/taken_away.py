# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The times in which a scenario itself keeps a user from being coupled: while the session starts,
in outages of a link, and while a node that it kills or stops does not run; each with the time
``BACK_S``, the soft start and a round trip to be coupled again.
"""

import numpy as np

from pmwvc_analysis.traces.intervals import merged
from pmwvc_core.frame.rows import Presence
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.network.effects import mean_s
from pmwvc_core.network.in_flight import Cause
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.disturbances import disturbances_of
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces

BACK_S = 1.0


def coupled(traces: SessionTraces, user: UserTraces) -> Flags:
    """Tell at which ticks a user is coupled: its master, and its avatar at the server."""
    server = traces.server
    if server is None or user.name not in server.users or not len(server.time_s):
        return np.zeros(len(user.time_s), dtype=bool)
    block = np.searchsorted(user.block_ends, np.arange(len(user.time_s)), side="right")
    master = user.state[np.minimum(block, len(user.state) - 1)] == SafetyState.COUPLED
    step = np.searchsorted(server.time_s, user.time_s, side="right") - 1
    avatar = server.state[server.users.index(user.name)][step] == Presence.COUPLED
    return np.asarray(master & avatar & (step >= 0))


def taken_away(traces: SessionTraces, user: UserTraces, scenario: Scenario) -> Flags:
    """Tell at which ticks the scenario takes the coupling of a user away."""
    known = next(each for each in scenario.users if each.name == user.name)
    back_s = BACK_S + known.safety.soft_start_s + mean_s(known.link_up) + mean_s(known.link_down)
    starts_s = [user.time_s[0]]
    if traces.server is not None and len(traces.server.time_s):
        starts_s.append(traces.server.time_s[0])
    found = [(0.0, float(max(starts_s)))]
    zeros = traces.metadata.get("fate_zero_ns", {})
    for name, fates in traces.fates.items():
        lost_ns = fates.time_in_ns[fates.cause == Cause.OUTAGE] - zeros.get(name, 0)
        found += [(time_s, time_s) for time_s in (lost_ns * 1e-9).tolist()]
    found += _stood_still(traces, scenario)
    away = np.zeros(len(user.time_s), dtype=bool)
    for interval in merged((start_s, end_s + back_s) for start_s, end_s in found):
        away[slice(*np.searchsorted(user.time_s, interval))] = True
    return away


def _stood_still(traces: SessionTraces, scenario: Scenario) -> list[tuple[float, float]]:
    """Return from when to when nodes did not run because the scenario asked for it [s]."""
    times_s = [each["time_s"] for each in traces.events if each.get("kind") == "disturbance"]
    found, since_s = [], dict[str, float]()
    for wanted, time_s in zip(disturbances_of(scenario.disturbances), times_s, strict=False):
        if wanted.node == "recorder":
            continue
        if wanted.action in ("kill", "stop"):
            since_s.setdefault(wanted.node, time_s)
        elif wanted.node in since_s:
            runs_s = _ran_s(traces, wanted.node)
            again_s = runs_s[runs_s >= time_s].min(initial=traces.duration_s)
            found.append((since_s.pop(wanted.node), float(again_s)))
    return found + [(time_s, traces.duration_s) for time_s in since_s.values()]


def _ran_s(traces: SessionTraces, node: str) -> Array:
    """Return the times at which a node is seen to run [s]."""
    if node == "server" and traces.server is not None:
        return traces.server.time_s
    rows = [user.time_s for user in traces.users if user.name == node]
    if node == "netem":
        topics = {f"/server/{user.name}/wave_up" for user in traces.users}
        rows = [traces.packets[topic].time_s for topic in topics & set(traces.packets)]
    return np.concatenate([*rows, [traces.duration_s]])
