# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows of a page from the samples of a session, recorded or running: the newest of each source
at the times of a grid, and the extremes of the ticks since the row before.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array, Integers
from pmwvc_view.protocol.snapshot import Layout

GONE_S = 0.5
DELAY_S = 0.5  # over which the delay of a link is the mean
ROUNDED_S = 1e-9


class Source(NamedTuple):
    """When samples were taken [s], and the columns of a row that they fill, with their values
    ``(samples, ...)``; nothing is known where the newest is older than ``within_s``.
    """

    time_s: Array
    parts: Sequence[tuple[slice, NDArray[Any]]]
    within_s: float = GONE_S


class UserTicks(NamedTuple):
    """When the ticks of a user were due [s], the force applied ``(tick, dof)`` [N], their lateness
    [s], and the time of the last one that a row before has shown [s].
    """

    user: str
    time_s: Array
    f_applied: Array
    lateness_s: Array
    shown_s: float = -math.inf


def rows_of(
    times: Array, layout: Layout, sources: Iterable[Source], ticks: Iterable[UserTicks],
    links: Sequence[Array],
) -> Array:  # fmt: skip
    """Return a row at each of some times [s], ``(rows, columns)``; NaN where nothing is known.
    ``links``: when packets were sent and arrived, ``(packets, 2)`` [s], in the order of snapshots.
    """
    rows = np.full((len(times), layout.size), math.nan)
    rows[:, 1] = times
    for time_s, parts, within_s in sources:
        at = newest(time_s, times, within_s=within_s)
        known = at >= 0
        at = at[known]
        for where, values in parts:
            rows[known, where] = values[at].reshape(-1, where.stop - where.start)
    for of_user in ticks:
        _write_extremes(rows, layout, of_user)
    for index, name in enumerate(layout.users):
        ways = [layout.slices[f"{name}.delay_{way}"] for way in ("up", "down")]
        for way, packets in zip(ways, links[2 * index : 2 * index + 2], strict=True):
            _write_delay(rows, way, packets)
        rows[:, layout.slices[f"{name}.round_trip"]] = sum(rows[:, way] for way in ways)
    return rows


def newest(of: Array, times: Array, *, within_s: float = math.inf) -> Integers:
    """Return the index of the newest sample at each time, -1 before the first, and where it is
    older than ``within_s``.
    """
    at = of.searchsorted(times + ROUNDED_S, side="right") - 1
    if within_s < math.inf and len(of):
        at[times - of[at] > within_s] = -1
    return at


def _write_extremes(rows: Array, layout: Layout, ticks: UserTicks) -> None:
    """Write the extremes of the ticks that no row has shown yet; those that came after their row
    was made are the next one's.
    """
    at = newest(ticks.time_s, rows[:, 1])
    first = newest(ticks.time_s, np.array([ticks.shown_s]))
    before = np.maximum(np.concatenate([first, at[:-1]]), first)
    some = np.flatnonzero(at > before)
    if not len(some):
        return
    for name, signal, least in (
        ("f_min", ticks.f_applied, np.minimum),
        ("f_max", ticks.f_applied, np.maximum),
        ("lateness", ticks.lateness_s.reshape(-1, 1), np.maximum),
    ):
        extremes = least.reduceat(signal[: at[some[-1]] + 1], before[some] + 1, axis=0)
        rows[some, layout.slices[f"{ticks.user}.{name}"]] = extremes


def _write_delay(rows: Array, where: slice, packets: Array) -> None:
    """Write the mean delay of the packets that came out within ``DELAY_S`` before a row."""
    times, own = rows[:, 1], packets[np.isfinite(packets[:, 1])]
    own = own[np.argsort(own[:, 1], kind="stable")]
    sums = np.concatenate([[0.0], np.cumsum(own[:, 1] - own[:, 0])])
    last = own[:, 1].searchsorted(times, side="right")
    first = own[:, 1].searchsorted(times - DELAY_S, side="right")
    some = last > first
    mean = (sums[last] - sums[first])[some] / (last - first)[some]
    rows[some, where] = mean.reshape(-1, 1)
