# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of a carry: of the cube, the grip on it, and the energy of the hands."""

import math

import numpy as np

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.result import SERVER
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

WITHIN_M = 5e-3  # of its target: the cube is placed
OF_DEVICE = ("device_kinetic", "device_damping")
OF_SERVER = ("contact_damping", "contact_stored", "object_kinetic", "object_damping")


def completion_s(traces: SessionTraces, scenario: Scenario) -> float:
    """Return how long a move of the cube took from the first motion of its target until the cube
    was within 5 mm of its end for good [s], median of the moves that the session completes;
    infinite where most did not end before the next one began.
    """
    server, task = traces.server, scenario.task
    if server is None:
        return math.inf
    times, took = server.time_s, []
    moved = np.flatnonzero(np.any(server.target != server.target[0], axis=-1))
    begin_s, leg_s = float(times[moved[0]]) if len(moved) else math.inf, task.move_rise_s
    leg_s += task.rest_s
    while begin_s + leg_s <= times[-1]:
        rows = (times >= begin_s) & (times < begin_s + leg_s)
        apart = np.linalg.norm(server.x_o[rows] - server.target[rows][-1], axis=-1)
        late = np.flatnonzero(~(apart <= WITHIN_M))  # also where it is no number
        last = int(late[-1]) + 1 if len(late) else 0
        took.append(last * server.period_s if last < rows.sum() else math.inf)
        begin_s += leg_s
    return float(sorted(took)[len(took) // 2]) if took else math.inf


def grip_lost(traces: SessionTraces) -> float:
    """Return the share of steps in which not all hands touched the cube, since they first did."""
    touching = np.all(traces.server.contact, axis=0) if traces.server else np.zeros(0, dtype=bool)
    held = np.flatnonzero(touching)
    return float(1.0 - touching[held[0] :].mean()) if len(held) else 1.0


def absorbed(traces: SessionTraces, scenario: Scenario) -> float | None:
    """Return what neither devices nor contacts nor cube had at the end, per work of the hands;
    None where it is not known.
    """
    found = budget(traces, scenario)
    if found is None:
        return None
    work = sum(float(np.diff(sums).clip(0.0).sum()) for sums in found.hands.values())
    parts = [
        float(sums[-1])
        for owner, each in found.parts.items()
        for part, sums in each.items()
        if part not in (OF_SERVER if owner == SERVER else OF_DEVICE)
    ]
    return sum(parts) / work if work > 0.0 else None
