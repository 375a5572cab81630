# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The limitation of a black box by its server port: energy withheld, and displacement by it.

A compensation that shortens a returning wave from v = u - sqrt(2/b) F to v' takes energy from the
user, and moves the device away from its avatar; a port that learns repays that::

    energy_j   = sum (|v|^2 - |v'|^2) T_VE/2
    position_m = largest |sum (u + v' - (2b)^(1/2) xd) T_VE (2 b_m)^(-1/2)|

The environment is lost where this displacement is most of the device's depth. With the avatar's
travel p in its present contact and the distance s between device and avatar, of which q is the
displacement above, the environment and the delay of the link alone explain |p| + |s - q|. Means
over 0.5 s; lost where for a whole second

    |q| > 2 mm + 3 (|p| + |s - q|).

Equations: docs/theory.md 5.10.
"""

from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.traces.reductions import begins
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.numeric import Array, root
from pmwvc_core.quantities import quantity
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_core.wave.impedance import WavePort

LEAST_J = 1e-9  # below this a returning wave was not shortened
WINDOW_S = 0.5
LASTING_S = 1.0
LOST_M = 2e-3
LOST_RATIO = 3.0


class Limited(NamedTuple):
    """Energy that the port withheld from one user, and the displacement by it."""

    energy_j: float
    position_m: float
    first_s: float  # time of the first wave that was shortened
    lost_s: float | None  # time from which the environment is lost; None: never


def limited(traces: SessionTraces, scenario: Scenario | None) -> dict[str, Limited]:
    """Return the users whose environment was limited, as far as scenario and trace show it."""
    server = traces.server
    if scenario is None or server is None or not has_waves(scenario.controller):
        return {}
    known, found = {user.name: user for user in scenario.users}, dict[str, Limited]()
    for user in traces.users if "withheld" in server.accounts else []:
        if user.name not in known or user.name not in server.users:
            continue
        index = server.users.index(user.name)
        port, there = WavePort(known[user.name].server_impedance), server.state[index] > 0
        u, v = np.nan_to_num(server.u_s[index]), np.nan_to_num(server.v_s[index])
        whole = np.asarray(port.v(u, np.nan_to_num(server.f_s[index])))
        half = 0.5 * server.periods_s
        withheld = np.where(there, half * np.sum(whole**2 - v**2, axis=-1), 0.0)
        energy = float(withheld.sum())
        if not energy > LEAST_J:
            continue
        off = u + v - port.u(np.nan_to_num(server.xd_s[index]), 0.0)
        off = np.where(there[:, np.newaxis], off / root(2.0 * known[user.name].impedance), 0.0)
        moved = np.cumsum(server.periods_s[:, np.newaxis] * off, axis=0)
        first_s = float(server.time_s[np.argmax(withheld > 0.01 * LEAST_J)])
        lost_s = _lost_s(user, server, index, moved)
        found[user.name] = Limited(energy, float(_length(moved).max()), first_s, lost_s)
    return found


def lost(traces: SessionTraces, scenario: Scenario | None) -> str:
    """Return whose environment is lost, in words; empty if none is."""
    for name, entry in limited(traces, scenario).items():
        if entry.lost_s is not None:
            return (
                f"{name}: the environment is lost from {entry.lost_s:.2f} s on: the energy limit "
                f"of the server port displaced the device by {entry.position_m * 1e3:.1f} mm"
            )
    return ""


def events(traces: SessionTraces, scenario: Scenario | None) -> list[dict[str, Any]]:
    """Return an event where the port first limits an environment, and one where it is lost."""
    found: list[dict[str, Any]] = []
    for name, entry in limited(traces, scenario).items():
        whole = f"{_amount(entry.energy_j, entry.position_m)} by the end"
        times = [(entry.first_s, f"environment limited by the server port ({whole})")]
        if entry.lost_s is not None:
            times.append((entry.lost_s, "environment lost"))
        found += [{"time_s": t, "who": name, "kind": "environment", "what": w} for t, w in times]
    return found


def words(entry: dict[str, float]) -> str:
    """Return an entry of the summary in words."""
    return f"environment limited: {_amount(**entry)}"


def _amount(energy_j: float, position_m: float) -> str:
    return f"{quantity(energy_j, 'J')}, {position_m * 1e3:.3g} mm"


def _lost_s(user: UserTraces, server: ServerTraces, index: int, moved: Array) -> float | None:
    """Return when the environment is lost first; an avatar of a later stay begins anew."""
    there = server.state[index] > 0
    for stay in np.split(np.arange(len(there)), np.flatnonzero(begins(there))):
        rows = stay[there[stay]]
        if not len(rows):
            continue
        apart = user.x_m[user.rows_at(server.time_s[rows])] - server.x_s[index][rows]
        apart, own = apart - apart[0], moved[rows] - moved[rows[0]]
        way = (server.x_s[index] - server.x_o)[rows]  # relative to the object
        touching = np.asarray(server.contact[index])[rows]
        before = np.maximum(np.arange(len(rows)) - 1, 0)
        since = np.maximum.accumulate(np.where(begins(touching), before, 0))
        travel = np.where(touching[:, np.newaxis], way - way[since], 0.0)  # in this contact
        natural = _length(_mean(travel, server.period_s))
        natural = natural + _length(_mean(apart - own, server.period_s))
        gone = _length(_mean(own, server.period_s)) > LOST_M + LOST_RATIO * natural
        count = max(1, round(LASTING_S / server.period_s))
        sums = np.concatenate([[0], np.cumsum(gone)])
        lasting = np.flatnonzero(sums[count:] - sums[:-count] == count)
        if len(lasting):
            return float(server.time_s[rows[lasting[0]]])
    return None


def _mean(values: Array, period_s: float) -> Array:
    """Return the mean over the last 0.5 s; before that, of the pause before the first value."""
    count = max(1, round(WINDOW_S / period_s))
    sums = np.cumsum(values, axis=0)
    before = np.concatenate([np.zeros_like(sums[:count]), sums[:-count]])[: len(sums)]
    return np.asarray((sums - before) / count)


def _length(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=-1))
