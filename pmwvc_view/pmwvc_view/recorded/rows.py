# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded session as rows of a page: the traces of every node at the times of a grid, the
balances as the report judges them.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_view.feed.traces import AVATAR, GONE_S, OBJECT, SIGNALS
from pmwvc_view.protocol.snapshot import PACKET, Layout

DELAY_S = 0.5  # over which the delay of a link is the mean


def rows_of(
    traces: SessionTraces, scenario: Scenario, layout: Layout, *, period_s: float
) -> Array:
    """Return the rows of a session, ``(rows, columns)``; NaN where nothing is known."""
    times = np.arange(0.0, traces.duration_s + 0.5 * period_s, period_s)
    rows = np.full((len(times), layout.size), math.nan)
    rows[:, 0] = np.arange(1, len(times) + 1)
    rows[:, 1] = times
    if traces.server is not None:
        _server(rows, layout, times, traces.server)
    for user in traces.users:
        if user.name in layout.users:
            _master(rows, layout, times, user)
    for energy in user_energies(traces, scenario):
        ways = (("up", energy.up), ("down", energy.down), ("hand", energy.joint))
        for name, balance in ways:
            if balance is not None and energy.name in layout.users:
                at, column = _newest(balance.time_s, times), f"{energy.name}.energy_{name}"
                least = np.minimum(np.minimum.accumulate(balance.balance_j), 0.0)
                _put(rows, layout, f"{column}_in", at, balance.energy_in_j)
                _put(rows, layout, f"{column}_out", at, balance.energy_out_j)
                _put(rows, layout, f"{column}_min", at, least)
    for name, targets in traces.targets.items():
        if name in layout.users:
            at = _newest(targets.time_s, times)
            _put(rows, layout, f"{name}.target", at, targets.position[:, : scenario.dof])
            _put(rows, layout, f"{name}.held", at, np.isfinite(targets.position[:, 0]))
    _delays(rows, layout, times, traces, scenario)
    return rows


def packets_of(traces: SessionTraces, scenario: Scenario) -> Array:
    """Return all packets of a session in the order of their sending, ``(packets, 5)``."""
    zeros = traces.metadata.get("fate_zero_ns", {})
    found = [np.empty((0, len(PACKET)))]
    for index, user in enumerate(scenario.users):
        for way, name in enumerate(("up", "down")):
            if (fates := traces.fates.get(f"{user.name}/{name}")) is None:
                continue
            zero_ns, link = zeros.get(fates.link, 0), np.full(len(fates.number), 2 * index + way)
            in_s, out_s = ((t - zero_ns) * 1e-9 for t in (fates.time_in_ns, fates.time_out_ns))
            arrived_s = np.where(fates.time_out_ns > 0, out_s, math.nan)
            found.append(np.column_stack([link, fates.number, in_s, arrived_s, fates.fate]))
    every = np.concatenate(found)
    return np.asarray(every[np.argsort(every[:, 2], kind="stable")])


def _put(rows: Array, layout: Layout, name: str, at: Integers, values: NDArray[Any]) -> None:
    """Write values ``(samples,)`` or ``(samples, dof)`` into a column; -1: none yet."""
    known = at >= 0
    columns = np.asarray(values, dtype=np.float64).reshape(len(values), -1)
    rows[known, layout.slices[name]] = columns[at[known]]


def _newest(of: Array, times: Array, *, within_s: float = math.inf) -> Integers:
    """Return the index of the newest sample at each time, -1 before the first, and where it is
    older than ``within_s``.
    """
    at = np.searchsorted(of, times + 1e-9, side="right").astype(np.int64) - 1
    at[(at >= 0) & (times - of[at] > within_s)] = -1
    return at


def _server(rows: Array, layout: Layout, times: Array, server: ServerTraces) -> None:
    at = _newest(server.time_s, times, within_s=GONE_S)
    for name in OBJECT:
        _put(rows, layout, f"object.{name}", at, getattr(server, name))
    for index, user in enumerate(server.users):
        if user in layout.users:
            for name in (*AVATAR, "contact"):
                _put(rows, layout, f"{user}.{name}", at, getattr(server, name)[index])
            _put(rows, layout, f"{user}.presence", at, server.state[index])


def _master(rows: Array, layout: Layout, times: Array, user: UserTraces) -> None:
    at = _newest(user.time_s, times)
    there = _newest(user.time_s, times, within_s=GONE_S)
    for name in SIGNALS:
        _put(rows, layout, f"{user.name}.{name}", there, getattr(user, name))
    newest = _newest(user.block_time_s, times, within_s=GONE_S)
    _put(rows, layout, f"{user.name}.state", newest, user.state)
    before = np.concatenate([[-1], at[:-1]])
    some = np.flatnonzero(at > before)
    if not len(some):
        return
    begins = before[some] + 1
    for name, signal, least in (
        ("f_min", user.f_applied, np.minimum),
        ("f_max", user.f_applied, np.maximum),
        ("lateness", user.lateness_s.reshape(-1, 1), np.maximum),
    ):
        extremes = least.reduceat(signal[: at[some[-1]] + 1], begins, axis=0)
        rows[some, layout.slices[f"{user.name}.{name}"]] = extremes


def _delays(
    rows: Array, layout: Layout, times: Array, traces: SessionTraces, scenario: Scenario
) -> None:
    """Write the mean delay of the packets that came out within ``DELAY_S`` before a row, and their
    sum as the round trip.
    """
    packets = packets_of(traces, scenario)
    for index, user in enumerate(scenario.users):
        for way, name in enumerate(("delay_up", "delay_down")):
            own = packets[packets[:, 0] == 2 * index + way]
            own = own[np.isfinite(own[:, 3])]
            own = own[np.argsort(own[:, 3], kind="stable")]
            sums = np.concatenate([[0.0], np.cumsum(own[:, 3] - own[:, 2])])
            last = np.searchsorted(own[:, 3], times, side="right")
            first = np.searchsorted(own[:, 3], times - DELAY_S, side="right")
            some = last > first
            mean = (sums[last] - sums[first])[some] / (last - first)[some]
            rows[some, layout.slices[f"{user.name}.{name}"]] = mean.reshape(-1, 1)
        up, down = (rows[:, layout.slices[f"{user.name}.delay_{way}"]] for way in ("up", "down"))
        rows[:, layout.slices[f"{user.name}.round_trip"]] = up + down
