# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of one carry: of cube and grip, and of the forces and energies of its hands."""

from collections.abc import Iterator

import numpy as np

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.result import SERVER
from pmwvc_analysis.traces.apart import apart
from pmwvc_core.frame import Presence
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

WITHIN_M = 5e-3  # of its target: the cube is placed
STAYS_S = 1.0
LONGEST_LAG_S = 2.0  # looked for
OF_DEVICE = ("device_kinetic", "device_damping")
OF_SERVER = ("contact_damping", "contact_stored", "object_kinetic", "object_damping")


def placed_s(traces: SessionTraces) -> float | None:
    """Return how long the cube took from the first motion of its target until it was near it for
    good [s]; None where it was not, or not for the last second.
    """
    server = traces.server
    if server is None:
        return None
    moved = np.flatnonzero(np.any(server.target != server.target[0], axis=-1))
    if not len(moved):
        return None
    near = np.linalg.norm(server.x_o - server.target, axis=-1) <= WITHIN_M
    there = max(moved[0], *(np.flatnonzero(~near)[-1:] + 1))
    if there == len(near) or server.time_s[there] > server.time_s[-1] - STAYS_S:
        return None
    return float(server.time_s[there] - server.time_s[moved[0]])


def grip_lost(traces: SessionTraces) -> float | None:
    """Return the share of steps in which not all hands touched the cube, since they first did;
    None where they never did.
    """
    touching = _touching(traces)
    return float(1.0 - touching.mean()) if touching is not None else None


def squeeze_n(traces: SessionTraces) -> float | None:
    """Return the mean force between the hands, the smallest at the contacts, since all first
    touched the cube [N]; None where they never did.
    """
    touching = _touching(traces)
    if touching is None or traces.server is None:
        return None
    forces = [np.linalg.norm(force, axis=-1) for force in traces.server.f_s]
    return float(np.min(forces, axis=0)[-len(touching) :].mean())


def _touching(traces: SessionTraces) -> Array | None:
    """Return for each step since they first did whether all hands touched the cube."""
    if traces.server is None:
        return None
    touching = np.all(traces.server.contact, axis=0)
    held = np.flatnonzero(touching)
    return touching[held[0] :] if len(held) else None


def apart_max_m(traces: SessionTraces) -> float | None:
    """Return the largest distance of a device from its avatar [m]."""
    found = [apart(traces, user) for user in traces.users]
    if any(each is None for each in found):
        return None
    return max(float(np.linalg.norm(each.error, axis=-1).max()) for each in found if each)


def lag_free_error_n(traces: SessionTraces) -> float | None:
    """Return the RMS of the force rendered less the contact force one lag earlier, of the lag of
    each user that makes it least [N]; None where there is no server.
    """
    errors = [
        min(
            float(np.mean(np.sum((rendered[lag:] - force[: len(force) - lag]) ** 2, axis=-1)))
            for lag in range(lags)
        )
        for rendered, force, lags in _forces(traces)
    ]
    return float(np.sqrt(np.mean(errors))) if errors else None


def _forces(traces: SessionTraces) -> Iterator[tuple[Array, Array, int]]:
    """Yield for each user the forces rendered and at the contact, step by step while coupled, and
    how many lags are looked at.
    """
    server = traces.server
    if server is None:
        return
    for user, force, state in zip(traces.users, server.f_s, server.state, strict=True):
        coupled = np.flatnonzero(state == Presence.COUPLED)
        steps = slice(coupled[0], None) if len(coupled) else slice(0)
        rows = np.searchsorted(user.time_s, server.time_s[steps] - 0.5 * user.tick_s)
        rendered = user.f_applied[np.clip(rows, 0, len(user.time_s) - 1)]
        lags = min(round(LONGEST_LAG_S / server.period_s), len(rows) // 2)
        if lags:
            yield rendered, force[steps], lags


def energies(traces: SessionTraces, scenario: Scenario) -> tuple[float, float] | None:
    """Return what neither devices nor contacts nor cube had at the end, per work of the hands, and
    how unequally the hands worked: 0 alike, 1 one of them alone. None where it is not known.
    """
    found = budget(traces, scenario)
    if found is None:
        return None
    works = [float(np.diff(sums).clip(0.0).sum()) for sums in found.hands.values()]
    work = sum(works)
    parts = [
        float(sums[-1])
        for owner, each in found.parts.items()
        for part, sums in each.items()
        if part not in (OF_SERVER if owner == SERVER else OF_DEVICE)
    ]
    return (sum(parts) / work, (max(works) - min(works)) / work) if work > 0.0 else None
